"""Conforming, rendering, presets, archives and reports."""

TEXTS: dict[str, str] = {
    # archive/engine.py
    "an archive needs Snakemake": "アーカイブには Snakemake が必要です",
    'Install it: pip install "mcsl[archive]"': 'インストールしてください: pip install "mcsl[archive]"',
    "Snakemake ended with {code}: {said}": "Snakemake がコード {code} で終わりました: {said}",
    "Read what it says there": "そこに書かれている内容を読んでください",
    "operations {start} to {start2}": "手術 {start}〜{start2}",
    "Planning {which}": "{which}の計画",
    "Working on {which}": "{which}の処理",
    # archive/job.py
    "{link_name}: is no link to the recording. Move it out of the folder of results": (
        "{link_name}: 収録へのリンクではありません。結果のフォルダーの外へ移してください"
    ),
    "{link_name}: a link to the recording cannot be made ({strerror}). Choose another file system": (
        "{link_name}: 収録へのリンクを作れません（{strerror}）。別のファイルシステムを選んでください"
    ),
    # archive/openjd.py
    "the sound of the preset {name} cannot be mixed by itself": "プリセット {name} の音声は単独でミックスできません",
    "Take h264 or prores": "h264 か prores を使ってください",
    "a template holds {MOST} tasks a step, these operations want {pieces}": (
        "テンプレートは 1 ステップに {MOST} タスクまでですが、これらの手術には {pieces} 必要です"
    ),
    "Hand the archive over in parts: a folder of fewer operations at a time": (
        "アーカイブを、手術の少ないフォルダーに分けて渡してください"
    ),
    "holds no operation with an EDL": "EDL のある手術がありません",
    "Run `mcsl archive` without --openjd first": "先に --openjd なしで `mcsl archive` を実行してください",
    "does not follow frame {after}": "フレーム {after} に続いていません",
    "Empty the folder, render again": "フォルダーを空にして、もう一度レンダリングしてください",
    "holds no pieces (0000001-0000600{suffix})": "断片 (0000001-0000600{suffix}) がありません",
    "Render them first": "先にレンダリングしてください",
    "holds frames up to {after}, the programme has {frames}": (
        "フレーム {after} までありますが、本編は {frames} フレームです"
    ),
    "Render what is missing, or empty the folder and render again": (
        "足りない分をレンダリングするか、フォルダーを空にしてもう一度レンダリングしてください"
    ),
    "stretches are removed, and Blender alone renders the whole programme": (
        "取り除いた区間がありますが、Blender だけでは本編全体がレンダリングされます"
    ),
    "{key} is left out: {error}": "{key} を外します: {error}",
    # archive/operations.py
    "is where the recordings lie": "収録のある場所です",
    "Choose a folder of its own for the results": "結果には別のフォルダーを選んでください",
    "names operations the other way": "手術の名前の付け方が違います",
    "Add --anonymous": "--anonymous を付けてください",
    "Leave --anonymous out": "--anonymous を外してください",
    "{how}, or choose another folder": "{how}。または別のフォルダーを選んでください",
    "is no folder": "フォルダーではありません",
    "Name the folder that the operations' folders lie in": ("手術のフォルダーが入っているフォルダーを指定してください"),
    "holds no folders": "フォルダーがありません",
    "has a column {unknown}": "{unknown} という列があります",
    "has no column 'operation'": "'operation' という列がありません",
    "Its first line names operation, and any of {COLUMNS}": (
        "1 行目に operation と、{COLUMNS} のうち使うものを書いてください"
    ),
    "there is no operation {folder}": "{folder} という手術はありません",
    "Name a folder in {archive}": "{archive} のフォルダーを指定してください",
    "{table}, line {line}": "{table} の {line} 行目",
    "names {folder} a second time": "{folder} が二度目です",
    "Leave one of the lines": "どちらかの行を外してください",
    "{parts} is no number of parts": "{parts} は分割の数ではありません",
    "Write a number from 1, or nothing": "1 以上の数を書くか、空にしてください",
    "holds results of {archive}": "{archive} の結果が入っています",
    "Choose another folder": "別のフォルダーを選んでください",
    "a table of operations": "手術の表",
    # archive/run.py
    "{count} operations": "手術 {count} 件",
    "{count} operation": "手術 {count} 件",
    "Looking through the archive": "アーカイブを調べる",
    "to do: {operations}, {jobs} jobs at most, {todo} of recording": (
        "これから: {operations}、ジョブは最大 {jobs}、収録 {todo}"
    ),
    "results: about {works}, beside {todo} of recording": "結果: 約 {works}（収録は {todo}）",
    "time: told as soon as one operation is done": "時間: 手術が一件終わると分かります",
    "time: about {took} of jobs one after another, as those took that are done": (
        "時間: 終わったものと同じなら、ジョブを順に行って約 {took}"
    ),
    # archive/triage.py
    "Ranking": "順位を付ける",
    # delivery/audio.py
    "{camera} has no sound, so the programme has none": "{camera} に音声がないので、本編にも音声がありません",
    "Sound": "音声",
    # delivery/conform.py
    "who makes a part does not know what others need": "一部分だけを作るジョブには、ほかに必要なものが分かりません",
    "Prune without a part, afterwards": "後で --part なしで --prune を実行してください",
    "The conformed pictures": "コンフォーム済みの映像",
    "Waiting for {holder}, which conforms into the same folder": ("同じフォルダーにコンフォームしている{holder}を待つ"),
    "Conforming": "コンフォーム中",
    # delivery/direct.py
    "all of {piece} is removed": "{piece} はすべて取り除かれています",
    "Choose other frames, or bring them back: mcsl remove": "別のフレームを選ぶか、元に戻してください: mcsl remove",
    "{taken} of {frames} frames are taken from {conformed}, where they are conformed": (
        "{frames} フレームのうち {taken} は、コンフォーム済みの {conformed} から取ります"
    ),
    "Writing the programme": "本編を書き出す",
    # delivery/parts.py
    "there is no part {number} of {of}": "{of} 分割の {number} 番目はありません",
    "Count from 1/N to N/N": "1/N から N/N で指定してください",
    "{text} is no part": "{text} は分割ではありません",
    "Write it as 2/8, the second of eight": "2/8（八つのうち二番目）のように書いてください",
    # delivery/presets.py
    "{attribute_name} must be one of {allowed}, got {value}": (
        "{attribute_name} は {allowed} のいずれかですが、{value} です"
    ),
    "{attribute_name} must lie in {low}..{high}, got {value}": (
        "{attribute_name} は {low}〜{high} ですが、{value} です"
    ),
    "{attribute_name}.{name} has an encoder open a file ({word})": (
        "{attribute_name}.{name} はエンコーダーにファイルを開かせます（{word}）"
    ),
    "blender.format must be {expected} for container {container}": (
        "コンテナー {container} では blender.format は {expected} でなければなりません"
    ),
    "blender.prores_profile belongs to codec 'PRORES' and only there": (
        "blender.prores_profile はコーデック 'PRORES' だけのものです"
    ),
    "there is no preset {name}": "プリセット {name} はありません",
    "Take one of {preset_names}, or the path of a .json file of your own": (
        "{preset_names} から選ぶか、自分の .json ファイルのパスを指定してください"
    ),
    "schema is {found}, this mcsl reads {SCHEMA}": "schema は {found} ですが、この mcsl が読むのは {SCHEMA} です",
    "Begin with a copy of one of render_presets/": "render_presets/ のどれかのコピーから始めてください",
    "{path} at $.schema": "{path} の $.schema",
    "a preset (presets.md)": "プリセット (presets.md)",
    # delivery/quality.py
    "there is no quality {name}": "品質 {name} はありません",
    "Take one of {QUALITIES}": "{QUALITIES} から選んでください",
    # delivery/source.py
    "there is no camera {name} to take the sound from": "音声を取るカメラ {name} がありません",
    "Choose one of {c_name}, or {NO_SOUND}": "{c_name} か {NO_SOUND} を選んでください",
    # report/field_picture.py
    "no camera has a picture then": "その時に画像のあるカメラがありません",
    "Choose another --range": "別の --range を選んでください",
    "frame {frame}": "フレーム {frame}",
    # report/page.py
    "What each camera sees over time is not known: {scores} is missing.": (
        "各カメラが時間とともに何を写すかは分かりません: {scores} がありません。"
    ),
    "{scores}: it lacks {lacking}": "{scores}: {lacking} がありません",
    "What each camera sees over time is not known: {why}.": ("各カメラが時間とともに何を写すかは分かりません: {why}。"),
    "The pictures cannot be shown: {error}.": "画像を表示できません: {error}。",
    "The steadiness cannot be measured: {error}.": "安定性を測れません: {error}。",
    # report/pictures.py
    "Taking the report's pictures": "報告書の画像を取る",
    # report/residuals.py
    "Comparing plane and surface": "平面と起伏を比べる",
    "hardware ({codec}) encodes the video": "ハードウェア（{codec}）で動画をエンコードします",
    "no hardware ({hwaccel}) here encodes this preset; {codec} does, on the processor": (
        "このプリセットをエンコードするハードウェア（{hwaccel}）がここにはありません。プロセッサーの {codec} "
        "でエンコードします"
    ),
}
