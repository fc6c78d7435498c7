"""The analysis: stages, notes and what it decided."""

TEXTS: dict[str, str] = {
    # alignment/anchoring.py
    "too little in common with the view before": "前の画像との共通点が少なすぎます",
    "the view before shows only {shown} of the field": "前の画像には術野の {shown} しか写っていません",
    "frames {pose_range}: {reason}; a new perspective begins": (
        "フレーム {pose_range}: {reason}。ここから新しい視点になります"
    ),
    # alignment/joint.py
    "its matches with {tied} contradict each other: they may show heads, not the field": (
        "{tied} との対応が互いに食い違っています。術野ではなく頭を写しているのかもしれません"
    ),
    "matches only {tied}, which cannot be tied to the reference camera either": (
        "{tied} とだけ対応しますが、それも基準カメラとつながりません"
    ),
    "no clear frame shows this camera together with another one": (
        "このカメラとほかのカメラが一緒に写る、はっきりしたフレームがありません"
    ),
    (
        "too few points in common with any other camera: at most {matches} distinct places, with {best}; "
        "{min_support} are needed"
    ): ("ほかのカメラとの共通の点が少なすぎます。最も多い {best} とでも {matches} か所で、{min_support} か所必要です"),
    (
        "its points match no other camera in one plane: {matches} distinct places match {best}, but they "
        "contradict each other or lie in one small spot"
    ): (
        "点がほかのどのカメラとも一つの平面で合いません。{best} と {matches} か所で対応しますが、"
        "食い違っているか、狭い所に固まっています"
    ),
    # alignment/pose_colours.py
    "Following the cameras' colours": "カメラの色を追う",
    # alignment/pose_solver.py
    "frames {frames}: camera {camera} is weak: {reason}": (
        "フレーム {frames}: カメラ {camera} は位置合わせが弱いです: {reason}"
    ),
    # alignment/poses.py
    "frames {pose_range}: its relief is left out, by which {cameras} would lie as no lamp does": (
        "フレーム {pose_range}: この起伏では {cameras} が無影灯にありえない位置になるので、起伏を使いません"
    ),
    "frames {piece}: the field that is drawn lies outside of the picture then": (
        "フレーム {piece}: 描いた術野がそこでは画面の外にあります"
    ),
    "Aligning the views": "画像の位置合わせ",
    # alignment/recorded_poses.py
    "frames {within}: {reference}, the reference camera, has no picture; the others lie by {stand_in}": (
        "フレーム {within}: 基準カメラ {reference} に画像がないので、ほかは {stand_in} に合わせます"
    ),
    # alignment/tracking/followed_poses.py
    "frames {pose_range}: {names} placed as the lamp holds them, not as tied": (
        "フレーム {pose_range}: {names} は対応点ではなく、無影灯上の位置に従って置きました"
    ),
    "frames {pose_range}: {held} placed as the lamp holds them": (
        "フレーム {pose_range}: {held} は無影灯上の位置に従って置きました"
    ),
    "frames {pose_range}: its views lie as the lamp was followed there": (
        "フレーム {pose_range}: そこで追った無影灯の動きに従って置きました"
    ),
    "Placing poses by the lamp": "無影灯に従って姿勢を置く",
    # alignment/tracking/movement_views.py
    "frames {movement_range}: the lamp cannot be followed; the programme holds its camera": (
        "フレーム {movement_range}: 無影灯を追えません。本編はカメラを固定します"
    ),
    "Following the lamp": "無影灯を追う",
    # analysis/cache.py
    "a kept result": "保存した結果",
    "{path} cannot be used ({why}) and is made again": "{path} は使えないので（{why}）、作り直します",
    # analysis/fields.py
    (
        "frames {stretch_range}: nothing shows where the surgical field lies, so the middle of the picture is "
        "taken; to draw it: mcsl field"
    ): ("フレーム {stretch_range}: 術野の位置が映像から分からないので、画面の中央を使います。描くには mcsl field"),
    "a field that is drawn was not used: it was drawn meanwhile, or lies outside of the picture": (
        "描いた術野を使いませんでした。その間に描かれたか、画面の外にあります"
    ),
    # analysis/measurements.py
    "Run `mcsl analyse` again": "`mcsl analyse` をもう一度実行してください",
    "a table of scores": "採点の表",
    "is not {wanted} ({error})": "{wanted}ではありません（{error}）",
    # analysis/pipeline.py
    "there is no stage {unknown}": "{unknown} という段階はありません",
    "Stages are {STAGES}": "段階は {STAGES} です",
    "that this EDL was made here cannot be remembered: other commands will want --allow-outside": (
        "この EDL をここで作ったことを覚えておけません。ほかのコマンドで --allow-outside が必要になります"
    ),
    "the decisions were made when other files were {changed}: see whether they still hold": (
        "決定をした時は、{changed} は別のファイルでした。今も正しいか見てください"
    ),
    "{unplaced} of {looks} looks are at cameras whose place in the programme is not known then": (
        "視線 {looks} 件のうち {unplaced} 件は、その時に本編での位置が分からないカメラに向いています"
    ),
    # analysis/place.py
    "is there already, and is no EDL that can be read ({what})": "すでにあり、EDL として読めません（{what}）",
    "Choose another name, correct it, or add --force to replace it": (
        "別の名前を選ぶか、直すか、--force を付けて置き換えてください"
    ),
    # analysis/settings.py
    'Give it as "30000/1001", 25 or 29.97': '"30000/1001"、25、29.97 のように指定してください',
    "gaze is files, got {value}": "gaze はファイルですが、{value} です",
    'Give it as ["a.csv", "b.csv"]': '["a.csv", "b.csv"] のように指定してください',
    "sample_s is seconds from picture to picture, got {value}": "sample_s は画像の間隔の秒数ですが、{value} です",
    "Give it as 1.0": "1.0 のように指定してください",
    "movement_view is {MOVEMENT_VIEWS}, got {value}": "movement_view は {MOVEMENT_VIEWS} ですが、{value} です",
    'Give it as "{MOVEMENT_VIEWS}"': '"{MOVEMENT_VIEWS}" のように指定してください',
    # analysis/summary.py
    "{count} cameras": "カメラ {count} 台",
    "{count} camera": "カメラ {count} 台",
    "{count} shots": "{count} ショット",
    "{count} shot": "{count} ショット",
    "{count} overrides": "手動変更 {count} 件",
    "{count} override": "手動変更 {count} 件",
    "{cameras}, {seconds} at {rate} frames/s, {shots}, {overrides}": (
        "{cameras}、{seconds}、{rate} フレーム/秒、{shots}、{overrides}"
    ),
    "weak: {camera}: {reason}": "位置合わせが弱い: {camera}: {reason}",
    "the lamp moves from {start} to {stop} (confidence {confidence})": (
        "無影灯の動き {start}〜{stop}（確信度 {confidence}）"
    ),
    "pose from {at}, perspective {perspective}: residual px {fits}": (
        "姿勢 {at} から、視点 {perspective}: 残差 px {fits}"
    ),
    "pose from {at}, perspective {perspective}: residual px none": "姿勢 {at} から、視点 {perspective}: 残差なし",
    "gaze of {file}: {used} of {samples} looks used": "視線 {file}: {samples} 件のうち {used} 件を使用",
    "and {spans} more": "ほか {spans} 件",
    "no picture: {camera_name} from {spans}{more}": "画像なし: {camera_name}、{spans}{more}",
    "nothing shows where the surgical field lies, the middle is taken (to draw it: mcsl field)": (
        "術野の位置が映像から分からないので、中央を使います（描くには mcsl field）"
    ),
    "the surgical field is the one drawn by hand": "術野は手描きのものです",
    "from {start} to {stop}: {words}": "{start}〜{stop}: {words}",
    # centering/gaze_files.py
    "{camera} is not a camera, expected one of {cameras}": (
        "{camera} というカメラはありません。あるのは {cameras} です"
    ),
    "is no number, and no time of hours, minutes and seconds such as 0:01:02.5": (
        "は数でも、0:01:02.5 のような時分秒の時刻でもありません"
    ),
    "{text} is no number": "{text} は数ではありません",
    "a file of gaze": "視線のファイル",
    "docs/how-to/look.md lists what is read": "読める形式は docs/how-to/look.md にあります",
    "Its first line names time, x and y. {REMEDY}": "1 行目に time、x、y の名前が必要です。{REMEDY}",
    "has the columns {named}, expected frame or time, x and y, or Tobii's or Pupil's": (
        "列は {named} です。frame か time と x と y、または Tobii か Pupil の列が必要です"
    ),
    "{places} is no place in the picture that was shown": "{places} は表示された画像の中の場所ではありません",
    "{time} has a unit of time that is not known": "{time} の時間の単位が分かりません",
    "Name them in the first line; {REMEDY}": "1 行目に名前を書いてください。{REMEDY}",
    "{path}, line 1": "{path} の 1 行目",
    "Export Gaze point X [MCS px]": "Gaze point X [MCS px] を書き出してください",
    "Units are {SECONDS}": "単位は {SECONDS} です",
    "none of its {blind} lines has eyes": "{blind} 行のどれにも目が写っていません",
    "holds no looks, its first line alone": "1 行目だけで、視線がありません",
    "Correct or delete the line": "行を直すか、消してください",
    "{path}, line {line}": "{path} の {line} 行目",
    "{time} names no unit, and a step of {step} does not tell": ("{time} に単位がなく、間隔 {step} からも分かりません"),
    "Write [ms] or [us] behind the column's name": "列の名前の後に [ms] か [us] と書いてください",
    (
        "{looks} of {looks2} looks lie outside of the programme, this line's first: it lasts {frames} s, they go "
        "from {seconds} to {seconds2} s"
    ): (
        "視線 {looks2} 件のうち {looks} 件が本編の外にあります（この行が最初です）。本編は {frames} 秒、視線は "
        "{seconds}〜{seconds2} 秒です"
    ),
    (
        "Times are seconds (milliseconds in a column time_ms) from the programme's first frame: subtract the "
        "moment at which it began from a clock's or an epoch's times"
    ): (
        "時刻は本編の最初のフレームからの秒数（列 time_ms ではミリ秒）です。時計やエポックの時刻からは、"
        "本編が始まった時刻を引いてください"
    ),
    "{x} should be a share of the picture, 0 to 1": "{x} は画面に対する割合で、0〜1 のはずです",
    "Correct the lines": "行を直してください",
    "{looks} of {looks2} looks lie past the picture of {width}x{height} pixels, this line's {x}, {y} first": (
        "視線 {looks2} 件のうち {looks} 件が {width}x{height} ピクセルの画面の外にあります（この行の {x}, {y} "
        "が最初です）"
    ),
    "Places are pixels of the programme or of the camera named, not of a screen: scale them": (
        "位置はモニターの画面ではなく、本編か指定したカメラのピクセルです。換算してください"
    ),
    "without eyes": "目なし",
    "past the picture": "画面の外",
    "before or after the programme": "本編の前か後",
    "{looks} of {samples} looks are used": "視線 {samples} 件のうち {looks} 件を使用",
    "{looks} of {samples} looks are used ({why}); {read_as}": (
        "視線 {samples} 件のうち {looks} 件を使用（{why}）。{read_as}"
    ),
    "{looks} of {samples} looks are used ({why})": "視線 {samples} 件のうち {looks} 件を使用（{why}）",
    "{looks} of {samples} looks are used; {read_as}": "視線 {samples} 件のうち {looks} 件を使用。{read_as}",
    "{time} in {unit}": "{time} は {unit}",
    "a look every {every_s} s": "視線は {every_s} 秒ごと",
    "places are shares of the picture, y upward": "位置は画面に対する割合、y は上向き",
    "places are shares of the picture": "位置は画面に対する割合",
    # compositing/compositor.py
    "is {size}x{size2}; a programme's size is even": "{size}x{size2} です。本編の大きさは偶数です",
    "Correct it, or analyse again": "直すか、もう一度解析してください",
    "$.size of the EDL": "EDL の $.size",
    # compositing/stand_ins.py
    "and no other camera has one: black": "ほかのカメラにも画像がないので黒になります",
    "{shown} is shown in its place": "代わりに {shown} を表示します",
    "{chosen} has no picture from {start} to {stop} (frames {piece}), {instead}": (
        "{chosen} は {start} から {stop}（フレーム {piece}）に画像がありません。{instead}"
    ),
    "{stretches} more stretches in which another camera is shown": (
        "別のカメラを表示する区間がほかに {stretches} あります"
    ),
    # movement/paper.py
    "Finding points that cameras share": "カメラに共通の点を探す",
    # movement/stillness.py
    "Detecting lamp movements": "無影灯の動きを検出",
    "Timing the movements": "動きの時刻を決める",
    # occlusion/scoring.py
    "Scoring the views": "画像の採点",
    # selection/close_looks.py
    "Looking closer": "詳しく見る",
    # selection/merits.py
    "Measuring how well the cameras see": "カメラの見え方を測る",
    # selection/selectors.py
    "there is no camera {camera}": "カメラ {camera} はありません",
    "Choose one of {cameras}": "{cameras} から選んでください",
    "no picture could be scored": "採点できる画像がありません",
    "Check that the recording is longer than one sample": "収録がサンプルの間隔より長いか確認してください",
    # selection/switch_refinement.py
    "Refining the switches": "切り替えを調整",
}
