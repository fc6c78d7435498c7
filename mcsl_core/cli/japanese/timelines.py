"""The Blender timeline: what Blender's child process says."""

TEXTS: dict[str, str] = {
    # blender_addon/core/corrections.py
    "stand differently in one pose (from frames {start} and {start2})": (
        "一つの姿勢の中で違う置き方になっています（フレーム {start} からと {start2} から）"
    ),
    "A correction holds for the whole pose: give both the same transform, or set one back": (
        "補正は姿勢全体のものです。両方を同じトランスフォームにするか、片方を元に戻してください"
    ),
    "strips {first_name} and {other_name} of {camera}": "{camera} のストリップ {first_name} と {other_name}",
    "is mirrored or scaled to nothing": "鏡像になっているか、大きさが 0 です",
    "Set its scale in the strip's transform": "ストリップのトランスフォームで拡大率を設定してください",
    "strip {strip_name} of {camera}, frame {start}": "{camera} のストリップ {strip_name}、フレーム {start}",
    # blender_addon/core/field.py
    "what is drawn past the programme's {frames} frames is not taken": (
        "本編の {frames} フレームより後に描かれたものは使いません"
    ),
    "frames {start} to {stop}": "フレーム {start}〜{stop}",
    (
        "programme {piece}: the field drawn in this timeline is not taken, since the EDL's was changed "
        "meanwhile: draw it again here if yours shall hold"
    ): (
        "本編の{piece}: EDL の術野がその間に変わったので、このタイムラインで描いた術野は使いません。"
        "こちらを使うなら、ここで描き直してください"
    ),
    "programme {piece}: the field drawn in the EDL gives way to what this timeline has": (
        "本編の{piece}: EDL で描いた術野ではなく、このタイムラインのものを使います"
    ),
    # blender_addon/core/identity.py
    "is of another recording than this timeline": "このタイムラインとは別の収録のものです",
    "is of another recording than this timeline, which was copied or moved here": (
        "このタイムライン（コピーか移動したもの）とは別の収録のものです"
    ),
    "has other automatic decisions than this timeline, which was copied or moved here": (
        "このタイムライン（コピーか移動したもの）とは自動の決定が違います"
    ),
    # blender_addon/core/multicam.py
    "no shot at the playhead": "再生ヘッドにショットがありません",
    "Add a Multicam strip there, or build the Programme anew from the EDL": (
        "そこに Multicam ストリップを加えるか、EDL から Programme を作り直してください"
    ),
    "{camera} lies on channel {source}, above the shot's own {channel}": (
        "{camera} はチャンネル {source} にあり、ショットのチャンネル {channel} より上です"
    ),
    "Move the cameras below the Programme channel": "カメラを Programme チャンネルより下に移してください",
    "strip {strip_name}": "ストリップ {strip_name}",
    "{camera} has no strip in this timeline": "{camera} のストリップがこのタイムラインにありません",
    "Build the timeline again": "タイムラインを作り直してください",
    # blender_addon/core/outside.py
    "{what} shows {path}, which is no file": "{what} が表示する {path} はファイルではありません",
    "{what} shows {path}, which is missing": "{what} が表示する {path} が見つかりません",
    "{what} shows {path}, which is {kind}: what it leads to is not opened": (
        "{what} が表示する {path} は{kind}なので、その先は開きません"
    ),
    "{what} shows {path}, from outside this project": "{what} は、このプロジェクトの外の {path} を表示しています",
    # blender_addon/core/overruled.py
    "and {lost} more stretches that were decided elsewhere": "ほかの場所で決められた区間がほかに {lost} あります",
    (
        "programme frames {start} to {stop}: {theirs}, decided elsewhere since this timeline was last pulled or "
        "built, gives way to {ours}, which it shows"
    ): (
        "本編フレーム {start}〜{stop}: このタイムラインを最後に読み取るか作るかした後にほかの場所で決められた "
        "{theirs} ではなく、ここに表示されている {ours} を使います"
    ),
    # blender_addon/core/read_overrides.py
    "the timeline takes the sound of {chosen}, which is not a camera of the EDL": (
        "タイムラインが音声を取る {chosen} は EDL のカメラではありません"
    ),
    "Choose one of {names} or {NO_SOUND} under Render": "レンダリングの欄で {names} か {NO_SOUND} を選んでください",
    "the timeline was built for {stop} frames, the EDL has {frames}": (
        "タイムラインは {stop} フレーム用ですが、EDL は {frames} フレームです"
    ),
    "Build the timeline again with `mcsl timeline`": "`mcsl timeline` でタイムラインを作り直してください",
    "shows channel {source}, which holds no camera": "表示しているチャンネル {source} にカメラがありません",
    "shows {names}, which is not a camera of the EDL ({known})": (
        "表示している {names} は EDL のカメラ（{known}）ではありません"
    ),
    "shows channel {source}, which holds no camera here": (
        "表示しているチャンネル {source} のここにカメラがありません"
    ),
    "shows channel {source}, which holds more than one camera here": (
        "表示しているチャンネル {source} のここにカメラが二台以上あります"
    ),
    "Set its channel to one of the cameras' ({channels})": "カメラのチャンネル（{channels}）のどれかにしてください",
    "Set its channel to one of the cameras' (none is left)": (
        "カメラのチャンネルのどれかにしてください（一つも残っていません）"
    ),
    "strip {strip_name}, programme frame {frame} (Blender's frame {frame2})": (
        "ストリップ {strip_name}、本編フレーム {frame}（Blender のフレーム {frame2}）"
    ),
    # blender_addon/core/removal.py
    "the whole programme is marked as removed: nothing is left to deliver": (
        "本編全体が取り除く印の中にあり、納品するものがありません"
    ),
    "Delete or trim a mark": "印を消すか短くしてください",
    "channel Removed": "チャンネル Removed",
    # blender_addon/core/times.py
    "is {odd}": "{odd} です",
    (
        "the programme's time is the recording's and cannot be cut or stretched. To leave a stretch out, cut the "
        "delivered video, or render a range of frames"
    ): (
        "本編の時間は収録の時間で、切ったり伸ばしたりできません。区間を除くには、納品した動画を切るか、"
        "フレームの範囲をレンダリングしてください"
    ),
    "Undo that: {LEAVE_OUT}": "元に戻してください。{LEAVE_OUT}",
    "camera strip": "カメラのストリップ",
    "conformed strip": "コンフォームのストリップ",
    "sound strip": "音声のストリップ",
    "{role} {film_name}, frame {start}": "{role} {film_name}、フレーム {start}",
    "{by} frame later": "{by} フレーム後",
    "{by} frame earlier": "{by} フレーム前",
    "{by} frames later": "{by} フレーム後",
    "{by} frames earlier": "{by} フレーム前",
    ", and {more} more strip at or after it": "（それ以降にほか {more} ストリップ）",
    ", and {more} more strips at or after it": "（それ以降にほか {more} ストリップ）",
    "stands {first} than it was recorded{others}": "収録された位置から {first}にずれています{others}",
    "Undo that, or move them back: {LEAVE_OUT}": "元に戻すか、それらを戻してください。{LEAVE_OUT}",
    "Undo that, or move it back: {LEAVE_OUT}": "元に戻すか、それを戻してください。{LEAVE_OUT}",
    "is drawn out beyond its pictures, which stand still there": ("画像より長く引き伸ばされていて、そこでは静止します"),
    "Drag its ends back, or delete it and conform again": "端を戻すか、消してもう一度コンフォームしてください",
    "the scene runs at {rate} frames/s, the programme at {rate2}": (
        "シーンは {rate} フレーム/秒ですが、本編は {rate2} です"
    ),
    "Set it back to {numerator} with the base {numerator2}, or undo. Another rate is made from the delivered video": (
        "{numerator}、ベース {numerator2} に戻すか、取り消してください。別のフレームレートは納品した動画から作ります"
    ),
    "Output Properties, Frame Rate": "出力プロパティ、フレームレート",
    "every {step}. frame": "{step} フレームごと",
    "stretched time": "時間のリマップ",
    "the scene renders {what}, which would run at another speed": (
        "シーンは{what}でレンダリングされ、速さが変わります"
    ),
    "Set the step to 1": "ステップを 1 にしてください",
    "Set old and new to the same number": "旧と新を同じ数にしてください",
    "Output Properties, Frame Range, Step": "出力プロパティ、フレーム範囲、ステップ",
    "Output Properties, Time Stretching": "出力プロパティ、時間ストレッチ",
    "and the {moved} after it stand {by} than they were built, and the cameras do not": (
        "とその後の {moved} が、作られた位置から {by}にずれていますが、カメラはずれていません"
    ),
    "Undo the edit that moved them all (a ripple?): {LEAVE_OUT}": (
        "すべてを動かした編集（リップル？）を取り消してください。{LEAVE_OUT}"
    ),
    "strip {moved_name}, frame {start}": "ストリップ {moved_name}、フレーム {start}",
    "the scene renders frames {first} to {last}, the programme has 1 to {frames}": (
        "シーンはフレーム {first}〜{last} をレンダリングしますが、本編は 1〜{frames} です"
    ),
    "the scene's pictures are {sizes}, the programme's {sizes2}: cut or framed in black, not scaled": (
        "シーンの画面は {sizes}、本編は {sizes2} です。拡大縮小せず、切り取るか黒で囲みます"
    ),
    "{film} stands {slip} than it was recorded, and is kept so": (
        "{film} は収録された位置から {slip}にずれていますが、そのままにします"
    ),
    "{film} is {odd}: it cannot follow new sound, and would be muted then": (
        "{film} は{odd}なので、新しい音声に合わせられません。その時は消音になります"
    ),
    "exact pictures are muted by hand, so the preview shows in frames {start} to {stop}": (
        "正確な映像が手動でミュートされているので、フレーム {start}〜{stop} はプレビューを表示します"
    ),
    # blender_addon/sequencer/build.py
    "Blender cannot read it as video": "Blender が動画として読めません",
    "Convert it to H.264 in MP4": "MP4 の H.264 に変換してください",
    "has {stop} frames, {piece_range} belong there": "{stop} フレームありますが、そこに入るのは {piece_range} です",
    "{camera}: {path} has {frames} frames, Blender counts {stop}": (
        "{camera}: {path} は {frames} フレームですが、Blender では {stop} フレームです"
    ),
    (
        "{camera}: {path} is mirrored for display, which Blender does not obey: its preview shows it the wrong "
        "way round, conformed pictures are right"
    ): (
        "{camera}: {path} は左右反転して表示する指定ですが、Blender はそれに従いません。"
        "プレビューは反転しますが、コンフォームした映像は正しくなります"
    ),
    # blender_addon/sequencer/delivered.py
    "Blender did not mix the sound": "Blender が音声をミックスしませんでした",
    "See whether the disk is full": "ディスクがいっぱいでないか確認してください",
    "plays frames {frame_start} to {frame_end}, where what is removed cannot be left out": (
        "フレーム {frame_start}〜{frame_end} を再生しますが、そこでは取り除いたものを除けません"
    ),
    "Set its frame range to 1 to {stop} or more": "フレーム範囲を 1〜{stop} かそれ以上にしてください",
    "scene {scene_name}": "シーン {scene_name}",
    # blender_addon/sequencer/edit.py
    "strip {strip_name} cannot be split at frame {frame}": (
        "ストリップ {strip_name} をフレーム {frame} で分割できません"
    ),
    "Put the file back, or correct the EDL's media paths": (
        "ファイルを元に戻すか、EDL のメディアのパスを直してください"
    ),
    "Name the video itself": "動画そのものを指定してください",
    # blender_addon/sequencer/marks.py
    "has no channel left above all strips for the marks over what is removed": (
        "取り除く印のためのチャンネルが、すべてのストリップの上に残っていません"
    ),
    "Move your highest strips down": "一番上のストリップを下へ移してください",
    "the sequencer": "シーケンサー",
    "ranges of frames": "フレームの範囲",
    "the scene": "シーン",
    # blender_addon/sequencer/notices.py
    "strip {strip_name}, frame {strip}": "ストリップ {strip_name}、フレーム {strip}",
    "strip {strip_name}, frame {strip},": "ストリップ {strip_name}、フレーム {strip}、",
    (
        "frames {start} to {stop} have no shot: the video shows what the analysis chose, the preview another "
        "camera; Revert to Automatic lays the shot again"
    ): (
        "フレーム {start}〜{stop} にショットがありません。動画には解析の選択、"
        "プレビューには別のカメラが表示されます。「自動に戻す」でショットが戻ります"
    ),
    "and {gaps} more stretches have no shot": "ショットのない区間がほかに {gaps} あります",
    "library {library_name}": "ライブラリ {library_name}",
    "channel {conformed}, Conformed, is muted: the preview shows in place of the exact pictures": (
        "チャンネル {conformed} (Conformed) がミュートされているので、正確な映像の代わりにプレビューを表示します"
    ),
    "strip {strip_name}, frame {start}": "ストリップ {strip_name}、フレーム {start}",
    "{where} is muted and decides nothing: your work on it ({done}) goes with the next rebuild": (
        "{where} はミュートされていて何も決めません。そこでの作業（{done}）は次に作り直す時になくなります"
    ),
    "{where}: your work on it ({done}) is hidden by the exact pictures; do it on those, or above": (
        "{where}: そこでの作業（{done}）は正確な映像に隠れています。正確な映像の上か、その上で行ってください"
    ),
    "{where} shows {filepath}, not {placed} as it was built": (
        "{where} は、作られた時の {placed} ではなく {filepath} を表示しています"
    ),
    "{where}: its camera is not in the EDL any more, so your work on it goes with the next rebuild": (
        "{where}: そのカメラは EDL にもうないので、そこでの作業は次に作り直す時になくなります"
    ),
    # blender_addon/sequencer/read.py
    "is a Multicam strip inside a meta strip, where it has no cameras": (
        "メタストリップの中の Multicam ストリップで、そこにはカメラがありません"
    ),
    "Separate the meta strip (Ctrl-Alt-G) and save": "メタストリップを分解 (Ctrl-Alt-G) して保存してください",
    "is a {role} strip of this timeline inside a meta strip, where it cannot be kept up to date": (
        "このタイムラインの {role} ストリップがメタストリップの中にあり、更新できません"
    ),
    "has {CENTRE} {value}; two numbers [dx, dy] are expected, or {AUTOMATIC}": (
        "{CENTRE} が {value} です。数 2 個 [dx, dy] か {AUTOMATIC} が必要です"
    ),
    "Correct it among the strip's custom properties, or remove it": (
        "ストリップのカスタムプロパティで直すか、取り除いてください"
    ),
    "the automatic choice by time": "時間ごとの自動の選択",
    "outlines of the surgical field": "術野の輪郭",
    "a transform of five numbers": "数 5 個のトランスフォーム",
    "on or off": "オンかオフ",
    (
        "the Centering strip or its keys were changed by hand, which is not read: to set the centre of a shot, "
        "use the panel (or the strip's property {CENTRE})"
    ): (
        "Centering ストリップかそのキーが手で変えられていますが、読み取りません。ショットの中心を設定するには、"
        "パネル（またはストリップのプロパティ {CENTRE}）を使ってください"
    ),
    (
        "the keys of {moved}, over a movement of the lamp, were changed by hand, which is not read: move the "
        "camera's strips before and after it instead"
    ): (
        "無影灯の動きの間の {moved} のキーが手で変えられていますが、読み取りません。"
        "その前後でカメラのストリップを動かしてください"
    ),
    # blender_addon/sequencer/read_times.py
    "shown every {strobe} frames": "{strobe} フレームごとの表示",
    "under the Speed effect {speeds}": "速度エフェクト {speeds} の下",
    # blender_addon/sequencer/renew.py
    "has no channel left above Conformed for your strips": (
        "Conformed の上に、あなたのストリップのためのチャンネルが残っていません"
    ),
    "strip {above_name} on channel {channel}": "チャンネル {channel} のストリップ {above_name}",
    "the EDL has other cameras, files or poses than this timeline: its camera strips were made anew": (
        "EDL のカメラ、ファイル、姿勢のどれかがこのタイムラインと違うので、カメラのストリップを作り直しました"
    ),
    "your strips moved up by {lift} channels, to lie above the Conformed channel": (
        "あなたのストリップを {lift} チャンネル上へ移し、Conformed チャンネルの上に置きました"
    ),
    "{name} is gone from the EDL, and with it your work on its strip {strip_name}": (
        "{name} は EDL からなくなり、そのストリップ {strip_name} での作業もなくなりました"
    ),
    # blender_addon/sequencer/scene_properties.py
    "has the custom property {name} {shown}, where {expected} is expected": (
        "カスタムプロパティ {name} が {shown} ですが、{expected}が必要です"
    ),
    "Another version of mcsl may have made it: remove the property, or build the timeline again": (
        "別のバージョンの mcsl が作ったのかもしれません。プロパティを取り除くか、タイムラインを作り直してください"
    ),
    "no scene": "シーンなし",
    "{scenes} scenes ({s_name})": "{scenes} 個のシーン（{s_name}）",
    "holds {count} with an mcsl timeline": "mcsl のタイムラインがあるのは{count}です",
    "One is needed; see `mcsl timeline`": "一つ必要です。`mcsl timeline` を見てください",
    "has a timeline of schema {found}, this mcsl reads {TIMELINE_SCHEMA}": (
        "タイムラインの schema は {found} ですが、この mcsl が読むのは {TIMELINE_SCHEMA} です"
    ),
    "Build it again with `mcsl timeline`, or install the mcsl that made it": (
        "`mcsl timeline` で作り直すか、それを作った mcsl をインストールしてください"
    ),
    "names the EDL {noted}, which is not there": "EDL {noted} を指していますが、そこにありません",
    "names the EDL {noted}, which {what}": "EDL {noted} を指していますが、それは{what}",
    (
        "Open it where it was made, keep the .blend and its EDL where they lay to each other, or say which EDL "
        "of this recording takes the decisions: mcsl pull {blend_name} -o EDL.json"
    ): (
        "作った場所で開くか、.blend と EDL の位置関係を保つか、この収録のどの EDL "
        "に決定を書くかを指定してください: mcsl pull {blend_name} -o EDL.json"
    ),
    # blender_addon/sequencer/sound.py
    "{path} has no sound": "{path} に音声がありません",
    "{start} to {stop}": "{start}〜{stop}",
    "frames {start}": "フレーム {start}",
    "you changed the sound of this timeline, so sound that is new in the recording stays out of it: programme {new}": (
        "このタイムラインの音声に手を加えてあるので、収録に新しく加わった音声は入れません: 本編 {new}"
    ),
    "the recording's sound is not in this timeline any more: it stays silent": (
        "収録の音声がこのタイムラインからなくなっているので、無音のままです"
    ),
    "in a meta strip": "メタストリップの中",
    "separate that": "それを分解",
    "take the retiming away": "リタイミングを外す",
    (
        "sound strip {name} (frame {start}) is {what}, where it cannot follow new sound: it is muted now; {undo} "
        "and unmute it to hear it"
    ): (
        "音声ストリップ {name}（フレーム {start}）は{what}なので、新しい音声に合わせられません。"
        "ミュートしました。聞くには、{undo}してからミュートを外してください"
    ),
    "sound strip {name} has no sound any more in frames {start} to {stop}": (
        "音声ストリップ {name} は、フレーム {start}〜{stop} にもう音声がありません"
    ),
    "you changed the sound of this timeline, so it stays: mute or delete what is not to be heard": (
        "このタイムラインの音声に手を加えてあるので、そのまま残します。聞かせないものはミュートするか消してください"
    ),
    # blender_addon/sequencer/touched.py
    "effect strip": "エフェクトストリップ",
    "keys of {paths}": "{paths} のキー",
    "transform {n}": "トランスフォーム {n}",
    "crop {name}": "クロップ {name}",
    # blender_addon/worker/confine.py
    "Stereoscopy is switched off: a render writes one video": (
        "立体視をオフにしました。レンダリングは一つの動画だけを書きます"
    ),
    "a File Output node in {where} is switched off: a render writes its video alone": (
        "{where}の File Output ノードをオフにしました。レンダリングは動画だけを書きます"
    ),
    "{what} is switched off: it keeps files of its own": "{what}をオフにしました。自分のファイルを残すためです",
    "the nodes {group_name}": "ノード {group_name}",
    "the scene {s_name}": "シーン {s_name}",
    "the fluid of {body_name}": "{body_name} の流体",
    "the disk cache of {body_name}": "{body_name} のディスクキャッシュ",
    "the disk cache of the scene {scene_name}": "シーン {scene_name} のディスクキャッシュ",
    # blender_addon/worker/tasks.py
    "wrote {done} of {total} frames": "{total} フレームのうち {done} フレームを書きました",
    "See the end of its log above": "上のログの終わりを見てください",
    "Build it with `mcsl timeline`": "`mcsl timeline` で作ってください",
    "Blender cannot open it ({error})": "Blender が開けません（{error}）",
    "Restore it or build it again": "元に戻すか、作り直してください",
    "cannot be written ({error})": "書き込めません（{error}）",
    "Choose a folder you may write to": "書き込めるフォルダーを選んでください",
    "the request of the task {task}": "タスク {task} の要求",
    "the surgical field is taken as it is drawn in this timeline": "術野はこのタイムラインに描かれたものを使います",
    "conformed pictures that no longer show what was decided fell away: `mcsl conform` makes others": (
        "決定と合わなくなったコンフォーム済みの映像を外しました。`mcsl conform` で作り直せます"
    ),
    "conformed pictures no longer show what was decided, and {error}": (
        "コンフォーム済みの映像が決定と合わなくなりました。また、{error}"
    ),
    "timeline": "タイムライン",
    "render": "レンダリング",
    "and {muted} more stretches show no shot because it is muted": (
        "ほか {muted} か所も、ミュートのためショットが表示されません"
    ),
    (
        "frames {start} to {stop} show no shot, because strip {name} is muted: the video shows what the "
        "analysis chose, the preview another camera; unmute it, or delete it and press Revert to Automatic"
    ): (
        "ストリップ {name} がミュートされているため、フレーム {start} から {stop} "
        "にショットが表示されません。動画には解析が選んだカメラ、プレビューには別のカメラが映ります。"
        "ミュートを解除するか、削除して「自動に戻す」を押してください"
    ),
}
