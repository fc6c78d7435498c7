"""Documents and other files: what is wrong with them, and what to do."""

TEXTS: dict[str, str] = {
    # arrays.py
    "{said} MB unpacked, at most {most} MB are read": "展開すると {said} MB です。読めるのは {most} MB までです",
    "{filename} holds objects, which could run a program": (
        "{filename} にオブジェクトが入っています。プログラムが実行されるおそれがあります"
    ),
    "{filename} is cut short": "{filename} は途中で切れています",
    "is not {wanted} ({why})": "{wanted}ではありません（{why}）",
    # children.py
    "a process of this work ended with code {returncode} and no answer": (
        "この作業のプロセスが、結果を返さずにコード {returncode} で終わりました"
    ),
    "Run again with fewer things open": "ほかのソフトを減らして、もう一度実行してください",
    # documents.py
    "must be {self}, got {value}": "{self}でなければなりませんが、{value} です",
    "must not be empty": "空にはできません",
    "true or false": "true か false",
    "a text": "文字列",
    "a whole number": "整数",
    "expected {words}, got {value}": "{words}が必要ですが、{value} です",
    "expected a whole number of at most 18 digits, got {value}": "18 桁までの整数が必要ですが、{value} です",
    "expected a number, got {value}": "数が必要ですが、{value} です",
    "expected a finite number, got {value}": "有限の数が必要ですが、{value} です",
    "expected a range [start, stop], got {value}": "範囲 [start, stop] が必要ですが、{value} です",
    "expected a list, got {value}": "リストが必要ですが、{value} です",
    "expected {wanted} values, got {value}": "値が {wanted} 個必要ですが、{value} 個です",
    "expected an object, got {value}": "オブジェクトが必要ですが、{value} です",
    "a document holds finite numbers only, got {number}": "文書に入れられるのは有限の数だけですが、{number} です",
    "a JSON document": "JSON 文書",
    "{what} (and {others} more faults)": "{what}（ほかに {others} 件の誤り）",
    "{what} (and 1 more fault)": "{what}（ほかに 1 件の誤り）",
    "Correct the value; docs/ describes {name}": "値を直してください。{name}の説明は docs/ にあります",
    "{where} at {path}": "{where} の {path}",
    "it is nested too deeply": "入れ子が深すぎます",
    "is not TOML: {why}": "TOML ではありません: {why}",
    "{low} or more": "{low} 以上",
    "{low} to {high}": "{low}〜{high}",
    "unknown key": "知らないキー",
    "{UNKNOWN}, expected one of {known}": "{UNKNOWN}です。使えるのは {known} です",
    # edl/checks.py
    "must be a tuple of three rows of three numbers, got {matrix}": "数 3 個の行が 3 行必要ですが、{matrix} です",
    "must be scaled so that its last element is 1, got {i}": (
        "最後の要素が 1 になるように正規化されていなければなりませんが、{i} です"
    ),
    "is singular: it maps the picture to a line or a point": "特異です。画像が線か点につぶれます",
    # edl/colour.py
    "frame {frame} is outside its pose's [{start}, {stop})": (
        "フレーム {frame} は姿勢の範囲 [{start}, {stop}) の外です"
    ),
    "keys must rise, got frame {frame} after {last}": (
        "キーは昇順でなければなりませんが、{last} の後に {frame} があります"
    ),
    # edl/edits.py
    "lies outside of the programme's {width}x{height} pixels": "本編の {width}x{height} ピクセルの外にあります",
    "the overrides count frames at {rate} per second, the new analysis at {rate2}": (
        "手動変更のフレームは毎秒 {rate} ですが、新しい解析は毎秒 {rate2} です"
    ),
    "Analyse with --rate {rate}, or remove the overrides from the old EDL": (
        "--rate {rate} を付けて解析するか、古い EDL から手動変更を取り除いてください"
    ),
    (
        "the overrides count from the first picture of {reference} and are laid in its perspective, the new "
        "analysis has {reference2} as its reference"
    ): (
        "手動変更は {reference} の最初の画像から数え、その視点に置かれていますが、新しい解析の基準は {reference2} です"
    ),
    "Analyse with --reference {reference}, or into another EDL": (
        "--reference {reference} を付けて解析するか、別の EDL に解析してください"
    ),
    "what was placed by hand counts pixels of a programme of {was}, the new analysis has {now}": (
        "手動で置いたものは {was} の本編のピクセルで数えていますが、新しい解析は {now} です"
    ),
    "Analyse the files of that size, or into another EDL": (
        "その大きさのファイルを解析するか、別の EDL に解析してください"
    ),
    "audio_from takes the sound of {audio_from}, which the new analysis has not": (
        "audio_from は {audio_from} の音声を指していますが、新しい解析にはそのカメラがありません"
    ),
    "Name the cameras as before, or remove audio_from from the old EDL": (
        "カメラの名前を前と同じにするか、古い EDL から audio_from を取り除いてください"
    ),
    "{at} takes camera {camera}, which the new analysis has not": (
        "{at} はカメラ {camera} を指していますが、新しい解析にはありません"
    ),
    "Name the cameras as before, or remove {at} from the old EDL": (
        "カメラの名前を前と同じにするか、古い EDL から {at} を取り除いてください"
    ),
    "{at} ends at frame {stop}, after the new end {frames}": (
        "{at} の終わりはフレーム {stop} で、新しい終わり {frames} より後です"
    ),
    "Analyse the whole recording, or shorten {at} in the old EDL": (
        "収録全体を解析するか、古い EDL で {at} を短くしてください"
    ),
    "drawn_fields[0] is drawn in the perspective of {reference}, the new analysis takes {reference2}'s": (
        "drawn_fields[0] は {reference} の視点で描かれていますが、新しい解析の視点は {reference2} です"
    ),
    "Analyse with --reference {reference}, or take the field away: mcsl field EDL --clear": (
        "--reference {reference} を付けて解析するか、術野を消してください: mcsl field EDL --clear"
    ),
    "what was changed here does not fit what was written into the file meanwhile ({fault})": (
        "ここでの変更が、その間にファイルに書かれた内容と合いません（{fault}）"
    ),
    "Open the file again and make the change there": "ファイルを開き直して、そこで変更してください",
    "{name} was changed here, and in the file as well since it was opened": (
        "{name} はここで変更されましたが、開いた後にファイルの中でも変更されています"
    ),
    "Open the file again and make the change there, or save under another name": (
        "ファイルを開き直してそこで変更するか、別の名前で保存してください"
    ),
    # edl/field.py
    "has {polygon} points where 3 to {MOST_POINTS} are taken": (
        "点が {polygon} 個あります。3〜{MOST_POINTS} 個でなければなりません"
    ),
    "has no area: its points lie on a line": "面積がありません。点が一直線に並んでいます",
    "expected one of {known}, got {by}": "{known} のいずれかが必要ですが、{by} です",
    # edl/outside.py
    "(and {others} more path)": "（ほか {others} 個のパス）",
    "(and {others} more paths)": "（ほか {others} 個のパス）",
    "leads out of the EDL's folder, to {target}{more}": "EDL のフォルダーの外の {target} を指しています{more}",
    (
        "If you trust this EDL, add --allow-outside to a command once, such as `mcsl look EDL --allow-outside`: "
        "it is remembered, in Blender too. In Python: mcsl.open(..., allow_outside=True)"
    ): (
        "この EDL を信頼する場合は、`mcsl look EDL --allow-outside` のように一度 --allow-outside "
        "を付けてください。Blender でも覚えています。Python では mcsl.open(..., allow_outside=True) です"
    ),
    "{path} at {at}": "{path} の {at}",
    # edl/relief.py
    "2 to {MOST_NODES} are taken": "2〜{MOST_NODES} 個でなければなりません",
    "has {rows} rows, {most}": "{rows} 行あります。{most}",
    "has {columns} nodes, {most}": "節点が {columns} 個あります。{most}",
    "has {found} rows, gamma has {rows}": "{found} 行ありますが、gamma は {rows} 行です",
    "has {row} nodes, gamma[0] has {columns}": "節点が {row} 個ありますが、gamma[0] は {columns} 個です",
    # edl/schema.py
    "expected two numbers, got {value}": "数が 2 個必要ですが、{value} です",
    "expected true or false, got {value}": "true か false が必要ですが、{value} です",
    "{lasts_s} s are longer than two days": "{lasts_s} 秒は 2 日より長すぎます",
    "frame {frame} is outside [0, {frames})": "フレーム {frame} は [0, {frames}) の外です",
    "a camera before it is also called {camera_name}": "前にも {camera_name} という名前のカメラがあります",
    "frame {frame} does not rise, or ends after all": "フレーム {frame} は昇順でないか、全体の終わりより後です",
    "lacks {missing}, not weak either": "{missing} がありません。弱いカメラにも挙げられていません",
    "the reference camera has no homography; it is the identity": (
        "基準カメラにホモグラフィがありません。単位行列です"
    ),
    "the reference camera's own homography must be the identity": (
        "基準カメラ自身のホモグラフィは単位行列でなければなりません"
    ),
    "everything is removed, nothing would be delivered": "すべて取り除かれていて、納品するものがありません",
    "{name} is not a camera, expected one of {names}": "{name} というカメラはありません。あるのは {names} です",
    "{piece} ends after the programme's {frames} frames": "{piece} は本編の {frames} フレームの終わりを越えています",
    "{piece} begins before the one before it ends at {last}": (
        "{piece} は、前の区間が {last} で終わる前に始まっています"
    ),
    # edl/serialization.py
    "an EDL": "EDL",
    "Hand in the file that `mcsl analyse` wrote": "`mcsl analyse` が書いたファイルを渡してください",
    "the EDL (edl.md)": "EDL (edl.md)",
    "an EDL is a JSON object": "EDL は JSON のオブジェクトです",
    "is {schema}, newer than this mcsl": "{schema} で、この mcsl より新しいものです",
    "is {schema}": "{schema} です",
    "{found}; expected {SCHEMA}": "{found}。必要なのは {SCHEMA} です",
    "Install a newer mcsl": "新しい mcsl をインストールしてください",
    "{where} at $.schema": "{where} の $.schema",
    # errors.py
    "cannot be written ({strerror})": "書き込めません（{strerror}）",
    "Make room, or choose another place": "空きを作るか、別の場所を選んでください",
    "Choose a place you may write to": "書き込める場所を選んでください",
    # input_files.py
    "a file": "ファイル",
    "is a folder, not {wanted}": "{wanted}ではなくフォルダーです",
    "Name the file itself": "ファイルそのものを指定してください",
    "something else": "別の種類のもの",
    "is {mode}, not {wanted}": "{wanted}ではなく{mode}です",
    "Save it as a file, and name that": "ファイルとして保存し、それを指定してください",
    "is larger than {most} MB: not {wanted}": "{most} MB を超えています。{wanted}ではありません",
    "Check the path": "パスを確認してください",
    "a folder": "フォルダー",
    "cannot be written: it is {kind}, no file": "書き込めません。ファイルではなく{kind}です",
    "does not exist": "見つかりません",
    "cannot be read ({strerror})": "読めません（{strerror}）",
    "Check the path and its permissions": "パスとアクセス権を確認してください",
    "is no name that a file can have": "ファイルの名前として使えません",
    "is {found}, not {wanted}": "{wanted}ではなく{found}です",
    "is not {encoding} text": "{encoding} のテキストではありません",
    "Save it as UTF-8, or check that it is {wanted}": "UTF-8 で保存するか、{wanted}かどうか確認してください",
    "Save it as UTF-8": "UTF-8 で保存してください",
    "is {data}, not {wanted}": "{wanted}ではなく{data}です",
    "is no text, not {wanted}": "テキストではなく、{wanted}ではありません",
    "Save it as UTF-8 text": "UTF-8 のテキストで保存してください",
    # json_text.py
    "the key {twice} stands twice in one object": "キー {twice} が一つのオブジェクトに二度あります",
    "{name} is not a number": "{name} は数ではありません",
    "{digits} is too large a number": "{digits} は大きすぎる数です",
    "a text in it is no Unicode": "中の文字列が Unicode ではありません",
    "is not JSON: {msg}": "JSON ではありません: {msg}",
    "The file may be cut short; restore it or make it again": (
        "ファイルが途中で切れているかもしれません。元に戻すか、作り直してください"
    ),
    "line {lineno}, column {colno}": "{lineno} 行目 {colno} 文字目",
    "is refused: {error}": "受け付けられません: {error}",
    "is nested too deeply": "入れ子が深すぎます",
    "is refused: a number has thousands of digits": "受け付けられません: 何千桁もの数があります",
    "Correct the file or make it again": "ファイルを直すか、作り直してください",
    # outputs/claim.py
    "is what this run reads{name}, and is never written over": "この実行が読むもの{name}なので、上書きしません",
    "Choose another name for the output": "出力に別の名前を選んでください",
    "is a folder": "フォルダーです",
    "Name a file in it": "その中のファイルを指定してください",
    "is no ordinary file": "通常のファイルではありません",
    "a file's name cannot hold a NUL character": "ファイルの名前に NUL 文字は使えません",
    "cannot be written ({why})": "書き込めません（{why}）",
    "is write-protected": "書き込み禁止です",
    "Choose another name, or add --force": "別の名前を選ぶか、--force を付けてください",
    "is there already, and not as mcsl wrote it": "すでにあり、mcsl が書いたままではありません",
    "Choose another name, or add --force to replace it": "別の名前を選ぶか、--force を付けて置き換えてください",
    "cannot be written ({there} is not a folder)": "書き込めません（{there} はフォルダーではありません）",
    "Choose another place": "別の場所を選んでください",
    # outputs/locks.py
    "another mcsl{holder} is at work on it ({what})": "別の mcsl{holder} が使っています（{what}）",
    "Wait for it to end, or choose another name": "終わるのを待つか、別の名前を選んでください",
    "another mcsl{holder} is writing it": "別の mcsl{holder} が書き込んでいます",
    "Wait for it to end, then try again": "終わるのを待って、もう一度試してください",
    "(process {file})": "（プロセス {file}）",
    # outputs/manifest.py
    "another content": "別の内容",
    "is not mcsl's list of what it wrote ({why})": "mcsl が書いたものの一覧ではありません（{why}）",
    "Move it away, then try again": "ほかへ移して、もう一度試してください",
    # tables.py
    "{text} is too large a number": "{text} は大きすぎる数です",
    "has {cells} cells, the first line names {columns} columns": (
        "セルが {cells} 個ありますが、1 行目の列は {columns} 個です"
    ),
    "Put text that holds the separator in quotation marks, and write a decimal point": (
        "区切り文字を含む文字列は引用符で囲み、小数点には点を使ってください"
    ),
    "is empty": "空です",
    "names the column {twice} twice": "列 {twice} が二度あります",
    "Rename one of the two": "どちらかの名前を変えてください",
    "{text} may be {whole} or {text2}": "{text} は {whole} とも {text2} とも読めます",
    "Write {whole} for thousands, {text}0 for a fraction": "桁区切りなら {whole}、小数なら {text}0 と書いてください",
    "unexpected end of data": "データが途中で終わっています",
    "a quotation mark is opened and not closed": "引用符が閉じていません",
    "a cell has more than {csv} characters, or a quotation mark is not closed": (
        "セルが {csv} 文字を超えているか、引用符が閉じていません"
    ),
    "cannot be read ({said})": "読めません（{said}）",
    # timing.py
    "a rate must lie in {LEAST_RATE} to {MOST_RATE} frames/s, got {rate}": (
        "フレームレートは {LEAST_RATE}〜{MOST_RATE} フレーム/秒でなければなりませんが、{rate} です"
    ),
    "a range starts at 0 or later, got [{start}, {stop}]": "範囲の始まりは 0 以上ですが、[{start}, {stop}] です",
    "a range ends after it starts, got [{start}, {stop}]": ("範囲の終わりは始まりより後ですが、[{start}, {stop}] です"),
    "{what} must tile [0, {frames}): {fault} at frame {at}, this is {piece}": (
        "{what}は [0, {frames}) を隙間も重なりもなく埋めなければなりませんが、フレーム {at} に{fault}があります。"
        "これは {piece} です"
    ),
    "{what} must tile [0, {frames}): they end at frame {at}": (
        "{what}は [0, {frames}) を隙間も重なりもなく埋めなければなりませんが、フレーム {at} で終わっています"
    ),
    "expected a rate such as '30000/1001' or '25', got {text}": (
        "'30000/1001' や '25' のようなフレームレートが必要ですが、{text} です"
    ),
    "a rate must be positive, got {text}": "フレームレートは正の数ですが、{text} です",
    "{text} is no time": "{text} は時刻ではありません",
    # errors.py: stopped
    "stopped": "停止しました",
    "The same command carries on where it stopped": "同じコマンドで続きから進みます",
    "Nothing half-written is left": "書きかけのものは残っていません",
    "another mcsl{holder}": "別の mcsl{holder}",
    # what lies there in place of what was wanted
    "a video": "動画",
    "a sound file": "音声ファイル",
    "a Blender file": "Blender のファイル",
    "a compressed file, perhaps Blender's": "圧縮されたファイル（Blender のものかもしれません）",
    "a picture": "画像",
    "a zip file, such as a spreadsheet or a table of scores": "zip ファイル（表計算のファイルや採点の表など）",
    "a compressed file": "圧縮されたファイル",
    "a PDF": "PDF ファイル",
    "a program": "プログラム",
    "a pipe": "パイプ",
    "a socket": "ソケット",
    "a device": "デバイス",
    "a playlist (ASF)": "プレイリスト (ASF)",
    "a playlist (ASX)": "プレイリスト (ASX)",
    "a playlist (DASH)": "プレイリスト (DASH)",
    "a playlist (HLS)": "プレイリスト (HLS)",
    "a playlist (PLS)": "プレイリスト (PLS)",
    "a list of files (ffconcat)": "ファイルの一覧 (ffconcat)",
    "a description of a network stream (SDP)": "ネットワークストリームの記述 (SDP)",
    "a description in XML (such as DASH or IMF)": "XML の記述（DASH や IMF など）",
    "a link to a network stream": "ネットワークストリームへのリンク",
    "a list of files (EDL)": "ファイルの一覧 (EDL)",
    "holds {value}, at most {most} are taken": "{value} 個あります。{most} 個までです",
    "{path}, line {number}": "{path} の {number} 行目",
}
