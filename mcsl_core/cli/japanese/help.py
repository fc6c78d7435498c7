"""--help, and what `mcsl plugins` lists."""

TEXTS: dict[str, str] = {
    # cli/commands/analyse.py
    "The EDL; an existing one keeps its overrides.": "EDL。すでにあれば手動変更は残ります。",
    "Whose perspective the programme keeps (default: the first).": "本編の視点になるカメラ（既定: 最初のカメラ）。",
    "Programme frames per second (default: the reference camera's).": (
        "本編の毎秒のフレーム数（既定: 基準カメラと同じ）。"
    ),
    "auto (first sure), timecode, audio, motion or none.": (
        "auto（最初に確かなもの）、timecode、audio、motion、none のいずれか。"
    ),
    "Where viewers looked (CSV): centres that, not the field.": (
        "見る人の視線 (CSV)。術野ではなく、それを中央にします。"
    ),
    "While the lamp moves: follow it, so that the programme stands still, or hold the camera.": (
        "無影灯が動く間: follow は追って本編を静止させ、hold はカメラを固定します。"
    ),
    "Neither use nor keep results of stages beside the EDL.": "段階の結果を EDL の横に残さず、使いもしません。",
    (
        "Decide everything: a recording becomes an EDL.\n"
        "\n"
        "RECORDING is a folder with one file per camera, or the camera files in order."
    ): (
        "すべてを決めて、収録から EDL を作ります。\n"
        "\n"
        "RECORDING は、カメラごとのファイルが入ったフォルダーか、順に並べたカメラのファイルです。"
    ),
    # cli/commands/archive.py
    "Folder of the results, one folder an operation.": "結果のフォルダー。手術ごとに一つのフォルダーができます。",
    "Options of single operations (CSV): reference, preset, plugins and the like.": (
        "手術ごとのオプション (CSV): 基準、プリセット、プラグインなど。"
    ),
    "Of this machine that are used (default: all).": "このコンピューターで使うコアの数（既定: すべて）。",
    "Cores a job asks for.": "一つのジョブが求めるコアの数。",
    "Snakemake's profile: Slurm, Kubernetes or whatever it names.": (
        "Snakemake のプロファイル: Slurm、Kubernetes など。"
    ),
    "How a job calls mcsl where it runs (default: by this Python).": (
        "ジョブが動く所での mcsl の呼び方（既定: この Python）。"
    ),
    "Say what would be done, how long and how large, and do nothing.": (
        "することと、かかる時間と大きさを示すだけで、何もしません。"
    ),
    "Write a job template for render farms in place of working.": (
        "実行せず、レンダーファーム用のジョブのテンプレートを書き出します。"
    ),
    "Call operations by number in folders, logs, triage and reports.": (
        "フォルダー、ログ、順位表、報告書で手術を番号で呼びます。"
    ),
    (
        "Work through all operations of ARCHIVE.\n"
        "\n"
        "ARCHIVE is a folder with a folder for each operation. Each is analysed, conformed, rendered without "
        "Blender,\n"
        "measured and reported; then a page ranks them by what needs a person. Done again it does only what is "
        "new.\n"
        "With --openjd those that have an EDL are rendered by the Blenders of a farm: Open Job Description, as "
        "YAML."
    ): (
        "ARCHIVE のすべての手術を処理します。\n"
        "\n"
        "ARCHIVE は、手術ごとのフォルダーが入ったフォルダーです。それぞれを解析し、コンフォームし、Blender "
        "なしでレンダリングし、測り、報告します。その後、人が見るべき順に並べたページを作ります。"
        "もう一度実行すると、新しいものだけを処理します。--openjd を付けると、EDL のある手術をレンダーファームの "
        "Blender でレンダリングします（Open Job Description、YAML 形式）。"
    ),
    # cli/commands/blender.py
    "A Blender, or a Python that has bpy.": "Blender か、bpy のある Python。",
    "Another than the usual one, beside it: 4.5, 5.0 or 5.2.": (
        "通常と別のバージョンを並べて使います: 4.5、5.0、5.2。"
    ),
    ("Install Blender for mcsl alone.\n\nInto an environment of its own, as a Python module (bpy)."): (
        "mcsl 専用の Blender をインストールします。\n\n専用の環境に、Python モジュール (bpy) として入れます。"
    ),
    "Say which Blender is used, why, and what it lacks.": "どの Blender をなぜ使うか、何が足りないかを示します。",
    # cli/commands/conform.py
    "Folder of the conformed media (default: EDL's name + .conformed).": (
        "コンフォーム済みメディアのフォルダー（既定: EDL の名前 + .conformed）。"
    ),
    "Of the conformed pictures: draft, standard or fine.": "コンフォームする映像の品質: draft、standard、fine。",
    "Chunks made at the same time (default: one a core).": "同時に作るチャンクの数（既定: コアごとに一つ）。",
    "Make the K-th of N parts by time; other jobs make the others meanwhile.": (
        "時間で N 分割した K 番目を作ります。残りはほかのジョブが同時に作ります。"
    ),
    "Delete chunks that the EDL no longer needs.": "EDL にもう必要のないチャンクを消します。",
    (
        "Make the exact programme pictures of EDL.\n"
        "\n"
        "From the original media, in full resolution, in chunks: only what is missing or changed is made.\n"
        "Qualities lie beside each other; a timeline shows the finest there is of each stretch.\n"
        "With --part several jobs, on several machines with one folder, share the work; each may be killed and "
        "repeated."
    ): (
        "EDL の本編の正確な映像を作ります。\n"
        "\n"
        "元のメディアから全解像度で、チャンクに分けて作ります。足りないものと変わったものだけを作ります。"
        "品質の違うものは並べて置かれ、タイムラインは区間ごとに最も良いものを表示します。--part を付けると、"
        "一つのフォルダーを共有する複数のコンピューターのジョブで分担できます。"
        "どれを中断して繰り返しても構いません。"
    ),
    # cli/commands/demo.py
    "Another seed is another operation.": "シードを変えると別の手術になります。",
    "The Blender to use (see: mcsl blender).": "使う Blender（mcsl blender を参照）。",
    (
        "The whole way once, on a simulated recording.\n"
        "\n"
        "Simulates it, analyses it, builds the timeline and renders the video.\n"
        "Everything goes into FOLDER (default: ./mcsl-demo)."
    ): (
        "模擬収録で、全体の流れを一度通します。\n"
        "\n"
        "収録を模擬し、解析し、タイムラインを作り、動画をレンダリングします。すべて FOLDER に入ります（既定: "
        "./mcsl-demo）。"
    ),
    # cli/commands/evaluate.py
    "Alignments by hand (JSON or CSV): measures Manual-alignment too.": (
        "手動の位置合わせ (JSON か CSV)。手動の位置合わせも測ります。"
    ),
    "What point pairs set by hand become.": "手動の点の組から求める変換。",
    "One in N pairs within shots; 0: switches alone.": "ショットの中で N 組に一つを測ります。0 なら切り替えだけ。",
    "Width of the pictures measured.": "測る画像の幅。",
    "Match the cameras' colours in all variants.": "すべての変種でカメラの色を合わせます。",
    "Test the ratings of a viewers' questionnaire (CSV) instead.": (
        "代わりに、見る人のアンケートの評価 (CSV) を検定します。"
    ),
    "Write the figures as CSV.": "数値を CSV で書き出します。",
    "Write the figures as JSON (mcsl report takes it).": "数値を JSON で書き出します（mcsl report で使えます）。",
    (
        "Measure how steady the programme of EDL is.\n"
        "\n"
        "ITF and AvSpeed without alignment, aligned by hand, and as mcsl makes it; "
        "docs/explanation/evaluation.md says how."
    ): (
        "EDL の本編がどれだけ安定しているかを測ります。\n"
        "\n"
        "位置合わせなし、手動、mcsl の三通りの ITF と AvSpeed を測ります。方法は docs/explanation/evaluation.md "
        "にあります。"
    ),
    # cli/commands/export.py
    "The document: .fcpxml, .xml, .otio or .edl.": "文書: .fcpxml、.xml、.otio、.edl。",
    "The conformed programme, a clip a shot, above the cameras; or the cameras alone, roughly aligned (default).": (
        "コンフォーム済みの本編（ショットごとのクリップ）をカメラの上に置くか、"
        "大まかに位置合わせしたカメラだけにするか（既定）。"
    ),
    "Of the first frame; with a semicolon, 01:00:00;00, drop-frame.": (
        "最初のフレームのもの。セミコロンを使った 01:00:00;00 はドロップフレームです。"
    ),
    "Folder of conformed media, for --exact (default: beside the EDL).": (
        "--exact で使うコンフォーム済みメディアのフォルダー（既定: EDL の横）。"
    ),
    (
        "Write the cut of EDL for another editor.\n"
        "\n"
        "Final Cut Pro and Resolve read .fcpxml, Premiere and Resolve .xml (Final Cut Pro 7's) and .otio, all "
        "else .edl\n"
        "(CMX3600). With --exact, the conformed pictures and sound are joined into two files beside it.\n"
        "What is changed there comes back with `mcsl pull`."
    ): (
        "EDL の編集結果を別の編集ソフト用に書き出します。\n"
        "\n"
        "Final Cut Pro と Resolve は .fcpxml、Premiere と Resolve は .xml（Final Cut Pro 7 形式）と .otio、"
        "そのほかは .edl (CMX3600) を読みます。--exact を付けると、コンフォーム済みの映像と音声をつないだ二つのフ"
        "ァイルを横に作ります。そこでの変更は `mcsl pull` で読み戻せます。"
    ),
    # cli/commands/field.py
    "Its corners; repeat for a field of several parts.": ("術野の角。複数の部分からなる術野では繰り返して指定します。"),
    "Take away what is drawn: the field is found in the pictures again.": (
        "描いたものを消します。術野はまた映像から探します。"
    ),
    "Only in the programme's frames from A up to B.": "本編のフレーム A から B の前までだけ。",
    "Only from here on: 1:02:03.5 or seconds.": "ここから: 1:02:03.5 または秒数。",
    "Only up to here.": "ここまで。",
    "A remark to keep with what is drawn.": "描いたものと一緒に残すメモ。",
    "Write a picture with the field's outline and rulers.": "術野の輪郭と目盛りの付いた画像を書き出します。",
    (
        "Say where the surgical field lies, draw it by hand, or show it.\n"
        "\n"
        "Corners are in pixels of the programme before centering, right and down from the top left; in the first\n"
        "perspective those are the reference camera's own. What is drawn stands in the EDL: the next `mcsl "
        "analyse` aligns,\n"
        "scores and centres by it, and keeps it. Without --range, --from and --to it holds over the whole "
        "programme."
    ): (
        "術野の位置を示すか、手で描くか、画像にします。\n"
        "\n"
        "角は、センタリング前の本編のピクセルで、左上から右と下へ数えます。"
        "最初の視点では基準カメラのピクセルと同じです。描いたものは EDL に残り、次の `mcsl analyse` "
        "がそれで位置合わせ、採点、センタリングをし、そのまま保ちます。--range、--from、--to "
        "がなければ本編全体に使います。"
    ),
    # cli/commands/join.py
    "The video; its name ends as the pieces' names do.": "動画。名前の終わりは断片の名前と同じにします。",
    "A file whose sound it has, coded as it is (default: FOLDER/sound.*).": (
        "音声を取るファイル。符号化は変えません（既定: FOLDER/sound.*）。"
    ),
    (
        "Join the pieces that a render farm made of one programme.\n"
        "\n"
        "FOLDER holds them, each named by its first and last frame: 0000001-0000600.mp4. Nothing is coded again."
    ): (
        "レンダーファームが一つの本編から作った断片をつなぎます。\n"
        "\n"
        "断片は FOLDER にあり、最初と最後のフレームが名前になっています: 0000001-0000600.mp4。"
        "再符号化はしません。"
    ),
    # cli/commands/look.py
    "Shift the surgical field to the middle.": "術野を画面の中央に寄せます。",
    "Fill what the chosen camera does not see.": "選んだカメラに写らない所を埋めます。",
    "Match the cameras' colours.": "カメラの色を合わせます。",
    "Align by the relief, where one was found.": "起伏が見つかった所では、それに沿って位置合わせします。",
    "Show the field under heads and arms.": "頭や腕に隠れた術野を表示します。",
    "Shift by this much in programme pixels, in place of the automatic.": (
        "自動の代わりに、本編のピクセルでこれだけずらします。"
    ),
    (
        "Switch the visual aids of EDL on or off.\n"
        "\n"
        "Nothing is analysed again. For the whole programme, or with --from and --to for a stretch of it, as an "
        "override.\n"
        "Without options: say how they stand."
    ): (
        "EDL の見やすくする補助をオン・オフします。\n"
        "\n"
        "解析はやり直しません。本編全体か、--from と --to を付ければその区間の手動変更になります。"
        "オプションなしでは今の状態を示します。"
    ),
    # cli/commands/plugin.py
    "What it does: {STAGES}.": "担う段階: {STAGES}。",
    "The folder, which must not be there yet (default: ./NAME).": (
        "フォルダー。まだないものを指定します（既定: ./NAME）。"
    ),
    "Write a plugin of your own (what there is: mcsl plugins).": (
        "自分のプラグインを書きます（今あるものは mcsl plugins）。"
    ),
    (
        "Write a small working plugin.\n"
        "\n"
        "It is there to be changed into yours. NAME is what it is chosen by, in small letters with hyphens. The "
        "folder holds\n"
        "pyproject.toml, the module, a test and a README; it can be installed and used as it is."
    ): (
        "小さな動くプラグインを書き出します。\n"
        "\n"
        "それを変えて自分のものにしてください。NAME は選ぶ時の名前で、小文字とハイフンを使います。フォルダーには "
        "pyproject.toml、モジュール、テスト、README が入り、そのままインストールして使えます。"
    ),
    # cli/commands/plugins.py
    "As JSON.": "JSON で表示します。",
    "List what can do each stage, built in or installed.": (
        "各段階で使えるもの（内蔵とインストール済み）の一覧を表示します。"
    ),
    # cli/commands/remove.py
    "The programme's frames from A up to B.": "本編のフレーム A から B の前まで。",
    "From here on: 1:02:03.5 or seconds.": "ここから: 1:02:03.5 または秒数。",
    "Up to here.": "ここまで。",
    "Deliver what was removed again: the stretch, or everything.": "取り除いた区間、またはすべてを元に戻します。",
    (
        "Leave a stretch of the programme out of the video.\n"
        "\n"
        "Times and frames are those of the whole programme, whatever is removed already. It is a decision that "
        "stands in the\n"
        "EDL: `mcsl render` and `mcsl export` close up where something is removed, and a video's sound fades over two "
        "frames\n"
        "there; the timeline and conformed media keep the whole programme. Without options: say what is removed."
    ): (
        "本編の区間を完成映像から除きます。\n"
        "\n"
        "時刻とフレームは、すでに取り除いたものに関係なく、本編全体のものです。この決定は EDL に残ります。`mcsl "
        "render` と `mcsl export` は取り除いた所を詰め、動画の音声はそこで 2 フレームかけてつなぎます。タイムラインと"
        "コンフォーム済みメディアには本編全体が残ります。オプションなしでは、取り除いたものを示します。"
    ),
    # cli/commands/render.py
    "The video.": "動画。",
    "A name or a preset file of your own.": "プリセットの名前か、自分のプリセットファイル。",
    "Blender renders titles and all; direct writes the same programme without Blender.": (
        "blender はタイトルなども含めてレンダリングし、direct は同じ本編を Blender なしで書き出します。"
    ),
    "Tint every pixel by its camera (with --engine direct).": (
        "ピクセルをカメラごとに色分けします（--engine direct で）。"
    ),
    ("Pull, conform and render to a video.\n\nSOURCE is an EDL or a .blend."): (
        "読み取り、コンフォーム、動画へのレンダリングをします。\n\nSOURCE は EDL か .blend です。"
    ),
    # cli/commands/report.py
    "The page (.html).": "ページ (.html)。",
    "From mcsl evaluate --json (default: measured at the switches).": (
        "mcsl evaluate --json の結果（既定: 切り替えの所で測ります）。"
    ),
    "No names of cameras, files, folders, no remarks; pictures show what they show.": (
        "カメラ、ファイル、フォルダーの名前もメモも出しません。画像に写っているものはそのまま見えます。"
    ),
    "Leave the pictures out.": "画像を入れません。",
    (
        "Write a page about EDL that is read in a minute.\n"
        "\n"
        "Cameras, shots, movements, alignment, clocks and steadiness; self-contained, for any browser."
    ): (
        "EDL について、一分で読めるページを書き出します。\n"
        "\n"
        "カメラ、ショット、動き、位置合わせ、時計、安定性。一つのファイルで完結し、どのブラウザーでも開けます。"
    ),
    # cli/commands/simulate.py
    "How long, in seconds.": "長さ（秒）。",
    "Of each camera, in pixels.": "各カメラの大きさ（ピクセル）。",
    "Frames per second.": "毎秒のフレーム数。",
    "How many.": "カメラの台数。",
    "How often the lamp is moved.": "無影灯を動かす回数。",
    "What is unlike the plain scene; may be given several times. Names: {FAMILIES}.": (
        "普通の場面と違う点。繰り返し指定できます。名前: {FAMILIES}。"
    ),
    "Two fields a frame, as theatre recorders write 1080i.": (
        "1 フレームに 2 フィールド（手術室のレコーダーの 1080i のように）。"
    ),
    "Ten bits of HLG or PQ in BT.2020, as phones do.": "BT.2020 の HLG か PQ の 10 ビット（携帯電話のように）。",
    "Variable frame rate: a quarter of the pictures is missing.": "可変フレームレート: 画像の四分の一が抜けます。",
    "A new file every so many seconds.": "この秒数ごとに新しいファイルにします。",
    "With --split: the parts' timestamps go on.": "--split と一緒に: 続きのファイルの時刻が続きます。",
    "Code in less time, into larger files.": "符号化を速くします。ファイルは大きくなります。",
    "Film the ideal programme, too: from one place, with nobody in the way.": (
        "理想の本編も撮影します。一か所から、遮る人なしで。"
    ),
    (
        "Make a recording with known truth.\n"
        "\n"
        "Camera files and truth.json go into the folder OUT, the ideal programme into OUT/ideal, which no "
        "analysis takes\n"
        "for a camera."
    ): (
        "真値の分かる収録を作ります。\n"
        "\n"
        "カメラのファイルと truth.json をフォルダー OUT に、理想の本編を OUT/ideal に書き出します。"
        "解析はそれをカメラとして扱いません。"
    ),
    # cli/commands/timeline.py
    "The .blend file.": ".blend ファイル。",
    "Render settings the file is given.": "ファイルに入れるレンダリングの設定。",
    "Folder of conformed media (default: beside the EDL, where present).": (
        "コンフォーム済みメディアのフォルダー（既定: EDL の横にあればそれ）。"
    ),
    "No sound at all (default: the reference camera's).": "音声なし（既定: 基準カメラの音声）。",
    "The EDL it was exported from; a .blend names its own.": ("書き出し元の EDL。.blend は自分の EDL を指しています。"),
    "The EDL to write (default: the one the changes belong to).": "書き込む EDL（既定: 変更の元の EDL）。",
    "The Blender to use for a .blend (see: mcsl blender).": ".blend に使う Blender（mcsl blender を参照）。",
    "Build the Blender timeline of EDL.": "EDL の Blender タイムラインを作ります。",
    (
        "Read the editor's changes in DOCUMENT as overrides.\n"
        "\n"
        "A .blend that `mcsl timeline` built; or what another editor made of an export: .fcpxml, .xml, .otio or "
        ".edl, with\n"
        "--edl. What is changed there and cannot be said in an EDL is named and left."
    ): (
        "編集者による DOCUMENT の変更を手動変更として読み取ります。\n"
        "\n"
        "`mcsl timeline` が作った .blend か、書き出したものを別の編集ソフトで編集した .fcpxml、.xml、.otio、"
        ".edl（--edl を付けて）。EDL で表せない変更は、何かを示して残します。"
    ),
    # cli/main.py
    "How long work reports: a bar, one line a stage, one JSON object a line on standard output, or not at all.": (
        "長い作業の進み方の表示: バー、段階ごとに一行、標準出力に JSON を一行ずつ、または表示なし。"
    ),
    "Show the traceback of an error.": "エラーのトレースバックを表示します。",
    (
        "One steady, unoccluded video from the cameras of a surgical lamp.\n"
        "\n"
        "\b\n"
        "recording --analyse--> EDL --timeline--> edit.blend\n"
        "          --pull--> overrides --render--> video\n"
        "\n"
        "Try it without a recording of your own: mcsl demo"
    ): (
        "無影灯のカメラ映像から、揺れも遮りもない一本の動画を作ります。\n"
        "\n"
        "\b\n"
        "収録 --analyse--> EDL --timeline--> edit.blend\n"
        "     --pull--> 手動変更 --render--> 動画\n"
        "\n"
        "自分の収録がなくても試せます: mcsl demo"
    ),
    # cli/options.py
    "Replace a file that mcsl did not write or that was changed since.": (
        "mcsl が書いたものでないか、その後変わったファイルも置き換えます。"
    ),
    "The EDL's media may lie outside of its folder, though it was not made here; remembered.": (
        "EDL がここで作られたものでなくても、メディアがそのフォルダーの外にあることを許します。覚えておきます。"
    ),
    "Whose sound is taken; none: no sound (default: as the EDL says).": (
        "音声を取るカメラ。none: 音声なし（既定: EDL のとおり）。"
    ),
    "Plugin that {purpose} (default: {default}).": "{purpose}プラグイン（既定: {default}）。",
    ("Hardware that decodes, and encodes with render --engine direct: auto, or as FFmpeg names it (cuda, vaapi)."): (
        "デコードするハードウェア。render --engine direct ではエンコードも: auto か、FFmpeg での名前（cuda、vaapi）。"
    ),
}
