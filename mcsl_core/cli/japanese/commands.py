"""The commands: wrong calls and results."""

TEXTS: dict[str, str] = {
    # cli/commands/archive.py
    "{operations} failed": "{operations}が失敗しました",
    "See why there, then run again": "そこで理由を見て、もう一度実行してください",
    "{openjd}: for those operations that have an EDL": "{openjd}: EDL のある手術の分",
    # cli/commands/blender.py
    "it lacks {missing}": "{missing} がありません",
    "does not start: {lacks}": "起動しません: {lacks}",
    # cli/commands/conform.py
    "{count} chunks": "{count} チャンク",
    "{count} chunk": "{count} チャンク",
    "{folder}: {chunks}, {made} made now": "{folder}: {chunks}、今回作ったもの {made}",
    # cli/commands/evaluate.py
    "--manual-fit says what --manual becomes, which is not given": (
        "--manual-fit は --manual の扱い方ですが、--manual がありません"
    ),
    "Give both or none": "両方指定するか、両方外してください",
    "takes an EDL, or --study with a file of ratings": "EDL か、評価のファイルを付けた --study が必要です",
    "See: mcsl evaluate --help": "mcsl evaluate --help を見てください",
    # cli/commands/field.py
    "--polygon {polygons} {what}": "多角形 --polygon {polygons}: {what}",
    "Give its corners in programme pixels; --show writes a picture with rulers": (
        "角を本編のピクセルで指定してください。--show で目盛り付きの画像を書き出せます"
    ),
    "--polygon {text} is no polygon": "--polygon {text} は多角形ではありません",
    'Write its corners right and down: "412,310 900,290 880,720"': (
        '角を右と下へのピクセルで書いてください: "412,310 900,290 880,720"'
    ),
    "--polygon and --clear are two wishes": "--polygon と --clear は一緒に使えません",
    "Draw anew without --clear: it replaces": "--clear なしで描き直してください。前のものと置き換わります",
    "a stretch is named, but nothing to do there": "区間の指定がありますが、そこですることがありません",
    "See: mcsl field --help": "mcsl field --help を見てください",
    "drawn by hand": "手描き",
    "found in the pictures": "映像から検出",
    "nothing shows it, the middle of the picture is taken": "映像から分からないので、画面の中央",
    "x {x} to {x2}, y {y} to {y2}": "x {x}〜{x2}、y {y}〜{y2}",
    "{start} to {stop}: {WORDS} ({about})": "{start}〜{stop}: {WORDS}（{about}）",
    "where the field lies is not written in this EDL: run `mcsl analyse` again, or draw it": (
        "この EDL には術野の位置が書かれていません。`mcsl analyse` をもう一度実行するか、描いてください"
    ),
    "`mcsl analyse` uses what is drawn now: alignment, scores, shots and centering are of before": (
        "描いた術野は次の `mcsl analyse` から使われます。位置合わせ、採点、ショット、センタリングは前のままです"
    ),
    "{show}: frame {frame}": "{show}: フレーム {frame}",
    # cli/commands/join.py
    "cannot write a {suffix} file": "{suffix} ファイルは書き出せません",
    "cannot write a nameless file": "拡張子のないファイルは書き出せません",
    "Choose a name that ends in {FORMATS}": "{FORMATS} で終わる名前を選んでください",
    "Joining": "つなぐ",
    "{out}: {out2}, {frames} frames": "{out}: {out2}、{frames} フレーム",
    # cli/commands/look.py
    "a stretch is named, but nothing to switch there": "区間の指定がありますが、そこで切り替えるものがありません",
    "See: mcsl look --help": "mcsl look --help を見てください",
    "Write pixels right and down: 40,-25": "右と下へのピクセル数で書いてください: 40,-25",
    "{text} is no shift": "{text} はずれではありません",
    "Write --centre 40,-25: pixels right and down": "--centre 40,-25 のように、右と下へのピクセル数で書いてください",
    "centred by hand, {offset},{value} px": "手動の中心、{offset},{value} px",
    "{start} to {stop}: {parts}": "{start}〜{stop}: {parts}",
    # cli/commands/plugin.py
    "{folder}: {noun} {name}. Install it: {python} -m pip install -e {install}": (
        "{folder}: {noun} {name}。インストール: {python} -m pip install -e {install}"
    ),
    "Use it: mcsl analyse ... --{stage} {name}": "使う: mcsl analyse ... --{stage} {name}",
    "Test it: {python} -m pytest {folder2}": "テスト: {python} -m pytest {folder2}",
    # cli/commands/remove.py
    "the video lasts {left} of {whole}": "動画の長さは {whole} のうち {left}",
    "nothing is removed: the video lasts {whole}": "取り除いたものはありません。動画の長さは {whole}",
    "{frame} to {value}: removed": "{frame}〜{value}: 取り除いた区間",
    # cli/commands/report.py
    "{out}: {out2}, open it in a browser": "{out}: {out2}、ブラウザーで開いてください",
    # cli/commands/simulate.py
    "--size {size} is no size": "--size {size} は大きさではありません",
    "Give it as 640x360": "640x360 のように指定してください",
    "See: mcsl simulate --help": "mcsl simulate --help を見てください",
    "{count} frames": "{count} フレーム",
    "{count} frame": "{count} フレーム",
    "{count} lamp movements": "無影灯の動き {count} 回",
    "{count} lamp movement": "無影灯の動き {count} 回",
    # cli/commands/timeline.py
    "--edl belongs to a document of another editor; a .blend names its own EDL": (
        "--edl はほかの編集ソフトの文書のためのものです。.blend は自分の EDL を指しています"
    ),
    "Name an .fcpxml, .xml, .otio or .edl file, or leave out --edl": (
        ".fcpxml、.xml、.otio、.edl のファイルを指定するか、--edl を外してください"
    ),
    "does not say which EDL it was exported from": "どの EDL から書き出されたか書かれていません",
    "Say which with --edl, such as: mcsl pull {document} --edl edl.json": (
        "--edl で指定してください。例: mcsl pull {document} --edl edl.json"
    ),
    "--blender is for a .blend": "--blender は .blend のためのものです",
    "Leave it out": "外してください",
    "{out}: open it in Blender, or render it: mcsl render {out2} -o VIDEO": (
        "{out}: Blender で開くか、レンダリングしてください: mcsl render {out2} -o VIDEO"
    ),
    "{count} changes": "変更 {count} 件",
    "{count} change": "変更 {count} 件",
    # cli/demo.py
    "is not empty": "空ではありません",
    "Name a new folder: mcsl demo FOLDER": "新しいフォルダーを指定してください: mcsl demo FOLDER",
    "alignment error over the field: {mean} px; the best single plane's for this relief: {best} px": (
        "術野での位置合わせの誤差: {mean} px（この起伏に最良の一枚の平面では {best} px）"
    ),
    "true movements: {true}": "真の動き: {true}",
    "true movements: none": "真の動き: なし",
    # cli/main.py
    "the memory does not suffice{told}": "メモリーが足りません{told}",
    "Close other programs, take fewer --jobs or smaller pictures, or a machine with more memory": (
        "ほかのソフトを閉じるか、--jobs を減らすか、画像を小さくするか、メモリーの多いコンピューターを使ってください"
    ),
    "Check the path, its permissions and the room on the disk": "パス、アクセス権、ディスクの空きを確認してください",
    "Make room on the disks that are written to, that of its output too": (
        "書き込み先のディスクに空きを作ってください。このコマンドの出力先のディスクもです"
    ),
    "is a link that leads to itself": "自分自身を指すリンクです",
    "Correct the link": "リンクを直してください",
    "Run again with `mcsl --debug ...` and report what it shows": (
        "`mcsl --debug ...` でもう一度実行し、表示された内容を報告してください"
    ),
    "internal error": "内部エラー",
    # cli/new_plugin.py
    "{name} is no name for a plugin": "{name} はプラグインの名前として使えません",
    "Take small letters, digits and single hyphens, such as usual-look": (
        "usual-look のように、小文字、数字、一つずつのハイフンを使ってください"
    ),
    "the name is that of the {noun} {offer}": "{noun} {offer} と同じ名前です",
    "Choose another name": "別の名前を選んでください",
    "its class would be called {cls}, which is taken": "クラスの名前が {cls} になりますが、それは使われています",
    "there is a Python package {module} already": "{module} という Python パッケージがすでにあります",
    "is there already": "すでにあります",
    "Choose another name, or another folder with -o": "別の名前か、-o で別のフォルダーを選んでください",
    # cli/options.py
    "holds characters that no file name has": "ファイルの名前に使えない文字があります",
    "holds a null character": "ヌル文字があります",
    "is too long: names have at most {LONGEST_NAME} bytes, paths {LONGEST_PATH}": (
        "長すぎます。名前は {LONGEST_NAME} バイト、パスは {LONGEST_PATH} バイトまでです"
    ),
    # cli/output.py
    "{progress} is no way to show progress": "{progress} という進捗の表示方法はありません",
    "Take one of {MODES}": "{MODES} から選んでください",
    # cli/stretches.py
    "from {start} to {stop} there is no frame": "{start} から {stop} までにフレームがありません",
    "from {start} to the end there is no frame": "{start} から終わりまでにフレームがありません",
    "from 0 to {stop} there is no frame": "0 から {stop} までにフレームがありません",
    "from 0 to the end there is no frame": "0 から終わりまでにフレームがありません",
    "The programme lasts {length}; give --from before --to": (
        "本編の長さは {length} です。--from は --to より前にしてください"
    ),
    "--range {text} is no range of frames": "--range {text} はフレームの範囲ではありません",
    "Write --range 900:1800": "--range 900:1800 のように書いてください",
    "--range {text} is not in the programme": "--range {text} は本編の中にありません",
    "Its frames are 0:{frames}": "フレームは 0:{frames} です",
    "Write 1:02:03.5, 2:30 or seconds": "1:02:03.5、2:30、または秒数で書いてください",
    "--range is given in frames, --from and --to in times": "--range はフレーム、--from と --to は時刻です",
    "Give one or the other": "どちらか一方を指定してください",
}
