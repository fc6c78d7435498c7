"""Blender itself, and the timelines that are built, read and rendered with it."""

TEXTS: dict[str, str] = {
    # blender/child.py
    "the add-on's files are missing": "アドオンのファイルがありません",
    "Install mcsl again": "mcsl をインストールし直してください",
    "was killed by {code_name}": "{code_name} で終了させられました",
    "ended with code {code} and no answer": "結果を返さずにコード {code} で終わりました",
    "Blender {version} {how}; its last words:": "Blender {version} が終了しました: {how}。最後の出力:",
    "Blender {version} {how}": "Blender {version} が終了しました: {how}",
    "Run again with fewer things open; if it comes back, another Blender may do (`mcsl blender`)": (
        "ほかのソフトを減らしてもう一度実行してください。また起きるなら、別の Blender "
        "なら動くかもしれません（`mcsl blender`）"
    ),
    "Blender's answer to the task {task}": "タスク {task} への Blender の返答",
    # blender/installation.py
    "no Blender was found (passed over: {passed_over})": (
        "Blender が見つかりません（使えなかったもの: {passed_over}）"
    ),
    "no Blender was found": "Blender が見つかりません",
    "4.5 LTS, 5.0 or 5.2 LTS": "4.5 LTS、5.0 または 5.2 LTS",
    "Run `mcsl blender install`, or name one ({SUPPORTED_TEXT}) by --blender or MCSL_BLENDER": (
        "`mcsl blender install` を実行するか、--blender か MCSL_BLENDER で指定してください（{SUPPORTED_TEXT}）"
    ),
    "{command} is not a program": "{command} はプログラムではありません",
    "Name a Blender {SUPPORTED_TEXT}": "Blender {SUPPORTED_TEXT} を指定してください",
    "given by --blender": "--blender で指定",
    "named by MCSL_BLENDER": "MCSL_BLENDER で指定",
    "`blender` on PATH": "PATH の `blender`",
    "the private environment of `mcsl blender install`": "`mcsl blender install` の専用環境",
    "{path} is a Python without bpy": "{path} は bpy のない Python です",
    "Run `mcsl blender install`": "`mcsl blender install` を実行してください",
    "{path} is neither a Blender nor a Python": "{path} は Blender でも Python でもありません",
    "{command} does not run ({error})": "{command} が動きません（{error}）",
    "Blender {number} at {command} is not supported": "{command} の Blender {number} には対応していません",
    "Use {SUPPORTED_TEXT}, or run `mcsl blender install`": (
        "{SUPPORTED_TEXT} を使うか、`mcsl blender install` を実行してください"
    ),
    "bpy in this Python": "この Python の bpy",
    "Blender {version} cannot start: the system lacks {missing}": (
        "Blender {version} が起動できません。システムに {missing} がありません"
    ),
    "; # and the packages that hold {unknown}": "; # と、{unknown} を含むパッケージ",
    "# and the packages that hold {unknown}": "# と、{unknown} を含むパッケージ",
    "Run: {missing}": "実行してください: {missing}",
    "bpy is installed but does not start: {said}": "bpy をインストールしましたが起動しません: {said}",
    "Run: {install}": "実行してください: {install}",
    "See `mcsl blender`": "`mcsl blender` を見てください",
    "bpy has wheels for Python {wheels} only; this is {own}, and none of them is on PATH": (
        "bpy の wheel は Python {wheels} 用だけです。これは {own} で、PATH にもありません"
    ),
    (
        "Install one of them (on Debian: apt-get install -y python{wheels}-venv), or name a Blender by --blender "
        "or MCSL_BLENDER"
    ): (
        "どれかをインストールするか（Debian では apt-get install -y python{wheels}-venv）、--blender か "
        "MCSL_BLENDER で Blender を指定してください"
    ),
    "{command} failed:": "{command} が失敗しました:",
    "See the lines above": "上の行を見てください",
    "there is no Blender {version} to install": "インストールできる Blender {version} はありません",
    "Take one of {WHEELS}": "{WHEELS} から選んでください",
    "{target} is there already; delete it to make it anew": "{target} はすでにあります。作り直すには消してください",
    "making an environment with Python {number}": "Python {number} の環境を作る",
    "installing {requirement}": "{requirement} をインストール",
    "starting it once": "一度起動する",
    "Python with Blender as a module,": "Blender をモジュールとして持つ Python、",
    # blender/messages.py
    "must be an absolute path, got {value}": "絶対パスでなければなりませんが、{value} です",
    "mcsl and its Blender extension must be of one version: install both anew": (
        "mcsl と Blender の拡張機能は同じバージョンでなければなりません。両方をインストールし直してください"
    ),
    "a line of progress": "進捗の行",
    # blender/preview.py
    "interlaced; Blender's preview shows combs where things move, conformed pictures are deinterlaced": (
        "インターレースです。Blender のプレビューでは動く所に櫛状のずれが出ますが、コンフォームした映像では解消されます"
    ),
    (
        "colours in {conversion}; Blender's preview may show others, conformed pictures are converted to BT.709. "
        "Grade those"
    ): (
        "色が {conversion} です。Blender のプレビューでは違う色になるかもしれませんが、コンフォームした映像は "
        "BT.709 に変換されます。色調整はそちらで行ってください"
    ),
    "and {paths} more": "ほか {paths} 件",
    # blender/render.py
    "there is no engine {engine}": "エンジン {engine} はありません",
    "Take one of {ENGINES}": "{ENGINES} から選んでください",
    "at least one chunk is made at a time, got {jobs}": "同時に作るチャンクは 1 個以上ですが、{jobs} です",
    "Choose 1 or more jobs": "1 以上のジョブを選んでください",
    "a review copy that shows where pixels come from is made directly": (
        "ピクセルの出どころを示す確認用の動画は直接書き出します"
    ),
    "Add --engine direct": "--engine direct を付けてください",
    "is neither an EDL (.json) nor a timeline (.blend)": "EDL (.json) でもタイムライン (.blend) でもありません",
    "the preset writes .{container} files": "このプリセットは .{container} を書き出します",
    "Name it {stem}.{container}, or take another preset": (
        "名前を {stem}.{container} にするか、別のプリセットを選んでください"
    ),
    "a timeline has its own sound": "タイムラインには自分の音声があります",
    "Change it in Blender, render its EDL, or take --audio {NO_SOUND}": (
        "Blender で変えるか、EDL をレンダリングするか、--audio {NO_SOUND} を使ってください"
    ),
    "is missing": "見つかりません",
    "Make it with `mcsl analyse` or `mcsl timeline`": "`mcsl analyse` か `mcsl timeline` で作ってください",
    # blender/timeline.py
    "a timeline has the sound that its EDL names or {NO_SOUND}, not that of {audio}": (
        "タイムラインの音声は EDL が指すものか {NO_SOUND} で、{audio} のものではありません"
    ),
    "Choose it in Blender (mcsl, Render, Sound), or set audio_from in the EDL": (
        "Blender で選ぶか（mcsl、レンダリング、音声）、EDL の audio_from を設定してください"
    ),
    "a timeline's name ends in .blend": "タイムラインの名前は .blend で終わります",
    "Name it so, such as edit.blend": "edit.blend のような名前にしてください",
    "is not a folder": "フォルダーではありません",
    "Make it with `mcsl conform`": "`mcsl conform` で作ってください",
    "is written again and again meanwhile": "その間に何度も書き換えられています",
    "Let the other program end, then pull": "ほかのプログラムが終わってから pull してください",
    "a timeline": "タイムライン",
    "Hand in the .blend file": ".blend ファイルを渡してください",
    "what is removed is marked on the timeline; rendered by Blender alone, it would be shown": (
        "取り除いた区間にはタイムライン上で印を付けました。Blender だけでレンダリングすると、そこも表示されます"
    ),
    "{edl} was written meanwhile, and is read again": "{edl} がその間に書き換えられたので、読み直します",
    "reading the timeline": "タイムラインを読む",
}
