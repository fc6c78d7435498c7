"""Documents of other editors."""

TEXTS: dict[str, str] = {
    # interchange/changes.py
    "none of its clips is of this EDL's media": "この EDL のメディアのクリップが一つもありません",
    "Relink them to the cameras' files, or hand in the EDL that it was exported from with --edl": (
        "カメラのファイルにつなぎ直すか、書き出し元の EDL を --edl で渡してください"
    ),
    "no file": "ファイルなし",
    "{count} clips": "{count} クリップ",
    "{count} clip": "{count} クリップ",
    "{clips} whose picture was moved, scaled or turned, the first at {at}": (
        "画像を動かしたり拡大・回転したりした {clips}、最初は {at}"
    ),
    "frames beyond the programme's end at {frames}": "本編の終わり {frames} より後のフレーム",
    "another order of the shots": "ショットの順番の変更",
    "{twice} frames that are shown more than once": "二度以上表示される {twice} フレーム",
    "the marker {name} at {frame}": "{frame} のマーカー {name}",
    # interchange/cmx_reading.py
    "an edit decision list (CMX3600)": "編集決定リスト (CMX3600)",
    "Hand in the .edl file as the editor exported it": "編集ソフトが書き出したままの .edl ファイルを渡してください",
    "has no events": "イベントがありません",
    "Check that it is {WHAT}": "{WHAT}かどうか確認してください",
    "Check the rate of the EDL and of this list": "EDL とこのリストのフレームレートを確認してください",
    "a change of speed in line {number}": "{number} 行目の速度の変更",
    # interchange/cmx_writing.py
    "an EDL counts to 99 frames a second, the programme has {rate}": (
        "EDL は毎秒 99 フレームまでですが、本編は {rate} です"
    ),
    "Export .fcpxml, .xml or .otio": ".fcpxml、.xml、.otio に書き出してください",
    # interchange/conformed.py
    "Conform again": "コンフォームし直してください",
    "holds {there} of the programme's {frames} frames in one quality": (
        "一つの品質では、本編の {frames} フレームのうち {there} フレームしかありません"
    ),
    "Run `mcsl conform {edl_path}` first, or export --angles": (
        "先に `mcsl conform {edl_path}` を実行するか、--angles で書き出してください"
    ),
    "Run `mcsl conform {edl_path}{also}` first": "先に `mcsl conform {edl_path}{also}` を実行してください",
    "lacks the sound of {sound_camera}": "{sound_camera} の音声がありません",
    "has {frames} frames at {rate}, the programme {frames2} at {rate2}": (
        "{frames} フレーム、{rate} ですが、本編は {frames2} フレーム、{rate2} です"
    ),
    "Joining the conformed pictures": "コンフォーム済みの映像をつなぐ",
    # interchange/export.py
    "Reading the cameras": "カメラを読む",
    "{camera} has {odd} frames/s, which editors do not know: they may round it": (
        "{camera} は {odd} フレーム/秒で、編集ソフトが対応していません。丸められるかもしれません"
    ),
    "{camera} runs at another rate than the programme: editors repeat or leave out pictures": (
        "{camera} は本編とフレームレートが違います。編集ソフトは画像を繰り返すか抜かします"
    ),
    "{camera} has no picture in the programme": "{camera} は本編に画像がありません",
    # interchange/fcpxml_reading.py
    "an FCPXML document": "FCPXML 文書",
    "has no project with a sequence": "シーケンスのあるプロジェクトがありません",
    "Export the project itself": "プロジェクトそのものを書き出してください",
    "Export it again from the editor": "編集ソフトからもう一度書き出してください",
    "the sequence has no format with a frameDuration": "シーケンスに frameDuration のある形式がありません",
    "the sequence has no spine": "シーケンスに spine がありません",
    "lane={value} is no whole number": "lane={value} は整数ではありません",
    "{name}={said} of <{tag}> is no time": "<{tag}> の {name}={said} は時刻ではありません",
    "of {sequences} projects the first is read, not {names}": (
        "{sequences} 個のプロジェクトのうち最初のものを読みます（{names} は読みません）"
    ),
    "a transition at frame {item}": "フレーム {item} のトランジション",
    "{tag} of {value} at frame {at_s}": "フレーム {at_s} の {value} の {tag}",
    "the clip {value} before the sequence's start, or of no length": (
        "シーケンスの始まりより前か、長さのないクリップ {value}"
    ),
    # interchange/formats.py
    "no editor's format is called so": "その名前に当たる編集ソフトの形式がありません",
    "Let its name end in {known}": "名前の終わりを {known} にしてください",
    # interchange/found.py
    "it says a time of more than {MOST} frames or seconds": "{MOST} フレームか秒を超える時刻があります",
    "the clip {name} at {range}": "{range} のクリップ {name}",
    # interchange/model.py
    "{range} would show pictures {source} to {source_stop} of {path_name}, which has {frames}": (
        "{range} は {path_name} の画像 {source}〜{source_stop} を表示することになりますが、{frames} 枚しかありません"
    ),
    # interchange/otio_reading.py
    "it is a {document}, not a Timeline": "Timeline ではなく {document} です",
    "it has no video": "映像がありません",
    "{value} is no rate": "{value} はフレームレートではありません",
    "an OpenTimelineIO document": "OpenTimelineIO 文書",
    "Hand in the .otio file as the editor exported it": ("編集ソフトが書き出したままの .otio ファイルを渡してください"),
    "is not {WHAT}, or misses what one has ({name}: {error})": (
        "{WHAT}ではないか、必要なものが欠けています（{name}: {error}）"
    ),
    "a {kind} {name} at frame {at}": "フレーム {at} の {kind} {name}",
    "the clip {value} at frame {start}, which has no file": "フレーム {start} のファイルのないクリップ {value}",
    "{value} is no number": "{value} は数ではありません",
    # interchange/pull.py
    "is no editor's document that mcsl reads": "mcsl が読める編集ソフトの文書ではありません",
    "runs at {rate} frames/s, the programme at {rate2}": "{rate} フレーム/秒ですが、本編は {rate2} です",
    "Export the sequence at its own rate": "シーケンスを元のフレームレートで書き出してください",
    "was exported from another analysis than this EDL holds now: what differs was not decided by the editor": (
        "この EDL の今の解析とは別の解析から書き出されています。違いは編集者が決めたものではありません"
    ),
    "Hand in the EDL that it was exported from with --edl, or export again": (
        "書き出し元の EDL を --edl で渡すか、もう一度書き出してください"
    ),
    "is {like_name} by what it holds, not {form_name}": "中身は {form_name} ではなく {like_name} です",
    "Let its name end in {suffix}": "名前の終わりを {suffix} にしてください",
    "shows nothing of the programme that is not removed already": "取り除かれていない本編が残りません",
    "Bring some of it back: mcsl remove": "一部を元に戻してください: mcsl remove",
    "Reading {form_name}": "{form_name} を読む",
    "frames {piece} ({start} to {stop})": "フレーム {piece}（{start}〜{stop}）",
    "removed: {piece} are left out of the video from now on": ("取り除きました: {piece}。これから完成映像に入りません"),
    "brought back: {piece} are in the video again": "元に戻しました: {piece}。また完成映像に入ります",
    "not read: {note}": "読まないもの: {note}",
    "was decided in the EDL, and the document does not know of it": (
        "EDL で決められていて、文書には反映されていないため"
    ),
    "kept: {piece} show {camera}, which {why}": "残しました: {piece} は {camera} のままです（{why}）",
    "overruled: {piece} showed {camera}, which {why}": "上書きしました: {piece} は {camera} でした（{why}）",
    # interchange/sequence.py
    "there is no drop-frame timecode at {rate} frames/s": (
        "{rate} フレーム/秒にドロップフレームのタイムコードはありません"
    ),
    "Write it with a colon": "コロンで書いてください",
    "editors know whole rates and NTSC's (30000/1001), the programme has {rate} frames/s": (
        "編集ソフトが対応するのは整数か NTSC (30000/1001) のフレームレートですが、本編は {rate} フレーム/秒です"
    ),
    "Analyse again with --rate, such as 25 or 30000/1001": (
        "--rate に 25 や 30000/1001 などを指定して、もう一度解析してください"
    ),
    # interchange/three_way.py
    "frames {piece} are there, which are removed: bring them back with mcsl remove": (
        "取り除いたフレーム {piece} があります。元に戻すには mcsl remove"
    ),
    # interchange/timecode.py
    "Write 01:00:00:00, or 01:00:00;00 for drop-frame at 29.97 and 59.94 frames/s": (
        "01:00:00:00 と書いてください。29.97 と 59.94 フレーム/秒のドロップフレームなら 01:00:00;00 です"
    ),
    "{text} is left out in drop-frame timecode": "{text} はドロップフレームでは欠番です",
    "Take the label after it": "その次の番号にしてください",
    # interchange/xmeml_reading.py
    "a Final Cut Pro 7 XML document (xmeml)": "Final Cut Pro 7 XML 文書 (xmeml)",
    "has no sequence": "シーケンスがありません",
    "Export the sequence itself": "シーケンスそのものを書き出してください",
    "the sequence has no rate": "シーケンスにフレームレートがありません",
    "{base} is no timebase": "{base} は timebase ではありません",
    "<{tag}>{text}</{tag}> of <{tag2}> is no whole number": "<{tag2}> の <{tag}>{text}</{tag}> は整数ではありません",
    "of {others} sequences the first is read, {name}, not {others2}": (
        "{others} 個のシーケンスのうち最初の {name} を読みます（{others2} は読みません）"
    ),
    "an effect": "エフェクト",
    # interchange/xml_text.py
    "Hand in {what} as the editor exported it": "編集ソフトが書き出したままの{what}を渡してください",
    "declares entities, which no editor writes": ("エンティティーの宣言があります。編集ソフトが書くものではありません"),
    "is not XML ({error})": "XML ではありません（{error}）",
    "is {tag}, not {what}": "{what}ではなく{tag}です",
    "is nested more than {MOST_DEPTH} deep": "入れ子が {MOST_DEPTH} 段より深いです",
    "Correct it, or export again": "直すか、もう一度書き出してください",
    "Take nested and compound clips apart. {remedy}": "入れ子や複合クリップをほどいてください。{remedy}",
    "a caption at frame {at_s}": "フレーム {at_s} のキャプション",
    "a level of the sound of {level} dB at {level2}": "{level2} の音声レベル {level} dB",
    "a title or generator {value} at frame {start}": "フレーム {start} のタイトルかジェネレーター {value}",
    "a transition of the sound at frame {item}": "フレーム {item} の音声のトランジション",
    "a transition {of}at frame {at}": "フレーム {at} の{of}トランジション",
    "a {child} has no source_range": "{child} に source_range がありません",
    "a {tag} {value} at frame {start}": "フレーム {start} の {tag} {value}",
    "begins as an event and is none that can be read": "イベントのように始まりますが、読み取れません",
    "channel {channel} of {own}": "{own}のチャンネル {channel}",
    "frames {piece}, in whose place lies what is not read: they stay as the EDL has them": (
        "フレーム {piece} の代わりに読み取れないものがあります。EDL のとおりにしておきます"
    ),
    "of the sound": "音声の",
    "the conformed sound": "コンフォーム済みの音声",
    "the marker {marker} of {name} at frame {start}": "フレーム {start} の {name} のマーカー {marker}",
    "the marker {value} of {name} at frame {at}": "フレーム {at} の {name} のマーカー {value}",
    "the sound of {of}": "{of} の音声",
    "the sound of {value} before the sequence's start, or of no length": (
        "シーケンスの始まりより前か、長さのない {value} の音声"
    ),
    "the sound {clip_name} at {clip_range}: {taken_from} is none of the programme's media": (
        "{clip_range} の音声 {clip_name}: {taken_from} は本編のメディアではありません"
    ),
    "the {what} {name}": "{what}「{name}」",
    "the {what} {name} at frame {start}, which is nested or a multiclip": (
        "フレーム {start} の {what} {name}（入れ子かマルチクリップ）"
    ),
    "the {what} {name} before the sequence's start, or of no length": (
        "シーケンスの始まりより前か、長さのない {what} {name}"
    ),
    "what {name} is trimmed to as a whole": "{name} 全体の切り出し",
    "{clip}: {taken_from} is none of the programme's media": "{clip}: {taken_from} は本編のメディアではありません",
    "{effect} of all of {name}": "{name} 全体の {effect}",
    "{effect} of {name} at frame {at}": "フレーム {at} の {name} の {effect}",
    "{effect} {of}{name} at frame {at}": "フレーム {at} の{of}{name} の {effect}",
    "{of} at frames {piece}": "フレーム {piece}: {of}",
    "{of} is heard without its picture": "{of}が画像なしで聞こえます",
    "{of} is not heard": "{of}が聞こえません",
    "{of} is of another moment than the picture": "{of}が画像と別の時点のものです",
    "{what} at frames {piece}": "フレーム {piece}: {what}",
    "{what} of {of} at frame {start}": "フレーム {start} の {of} の {what}",
    "the transition {event} of event {event2}": "イベント {event2} のトランジション {event}",
    "the clip {clip_name} at frame {start}, which has no reel": (
        "フレーム {start} のクリップ {clip_name}（リールがありません）"
    ),
}
