"""Evaluation, simulated recordings, and decisions taken in Python."""

TEXTS: dict[str, str] = {
    # api/programme.py
    "an EDL is opened by its path, got {path}": "EDL はパスで開きますが、{path} です",
    'Give it as mcsl.open("edl.json")': 'mcsl.open("edl.json") のように指定してください',
    "the override decides nothing": "手動変更が何も決めていません",
    "Give one of {decided}": "{decided} のいずれかを指定してください",
    "See help(Programme.override)": "help(Programme.override) を見てください",
    "has changes that are not saved": "保存していない変更があります",
    "Call save(), or save(another path) to leave the file as it is": (
        "save() を呼ぶか、ファイルをそのままにするなら save(別のパス) を呼んでください"
    ),
    "keeps no scores": "採点を残していません",
    # api/removal.py
    "Leave some of the programme": "本編の一部は残してください",
    # evaluation/evaluate.py
    "every must be 0 or more and the width 16 or more, got {every} and {width}": (
        "every は 0 以上、幅は 16 以上ですが、{every} と {width} です"
    ),
    "the variant {variant_name} does not show the same shots of the same cameras": (
        "変種 {variant_name} は、同じカメラの同じショットを表示していません"
    ),
    "Measuring the programme": "本編を測る",
    # evaluation/manual_alignment.py
    "expected one of points, transform, homography, got {given}": (
        "points、transform、homography のいずれかが必要ですが、{given} です"
    ),
    "expected one of points, transform, homography, got none": (
        "points、transform、homography のいずれかが必要ですが、ありません"
    ),
    "expected a pose or a frame in it, got both": "姿勢か、その中のフレームの一方が必要ですが、両方あります",
    "expected four or more point pairs, got {points}": "点の組が 4 個以上必要ですが、{points} 個です",
    "the points lie in one place on one side": "片側の点が一か所に固まっています",
    "the points lie on a line": "点が一直線に並んでいます",
    "expected as many points (x, y) on either side, got shapes {shape} and {shape2}": (
        "両側に同じ数の点 (x, y) が必要ですが、形は {shape} と {shape2} です"
    ),
    "expected at least {least} point pairs, got {a}": "点の組が {least} 個以上必要ですが、{a} 個です",
    "a point lies at {largest} pixels": "{largest} ピクセルの所に点があります",
    "is no alignment: a number in it is too large or none": (
        "位置合わせではありません。大きすぎるか、数でないものがあります"
    ),
    "is singular or nearly so: the picture becomes a line or a point, or huge": (
        "特異か、それに近いです。画像が線や点につぶれるか、巨大になります"
    ),
    "lays a part of the picture behind the viewer": "画像の一部が見る人の後ろに来ます",
    "{text} is no pose": "{text} は姿勢ではありません",
    "{fit} is no fit for point pairs": "点の組の当てはめ方 {fit} はありません",
    "Take one of {FITS}": "{FITS} から選んでください",
    "camera {camera} is shown at frames {shown} and was not aligned by hand": (
        "カメラ {camera} はフレーム {shown} に表示されますが、手動で位置合わせされていません"
    ),
    "Add its point pairs (docs/how-to/evaluation.md)": "点の組を加えてください (docs/how-to/evaluation.md)",
    "pose {index}": "姿勢 {index}",
    "the cameras' alignments by hand do not go together ({fault})": (
        "カメラの手動の位置合わせが互いに合いません（{fault}）"
    ),
    "Check that of camera {reference}, which the others lead through": (
        "ほかのカメラの元になるカメラ {reference} の位置合わせを確認してください"
    ),
    "a file of alignments by hand": "手動の位置合わせのファイル",
    "docs/how-to/evaluation.md has an example": "例は docs/how-to/evaluation.md にあります",
    "The columns are {COLUMNS}; docs/how-to/evaluation.md has an example": (
        "列は {COLUMNS} です。例は docs/how-to/evaluation.md にあります"
    ),
    "alignments by hand (evaluation.md)": "手動の位置合わせ (evaluation.md)",
    "the EDL has no such camera": "EDL にそのカメラはありません",
    "It has {sizes}": "あるのは {sizes} です",
    "{path}, camera {camera}": "{path} のカメラ {camera}",
    "{path}, camera {camera}, pose {pose}": "{path} のカメラ {camera}、姿勢 {pose}",
    "Take points that are spread over the field": "術野に広がった点を取ってください",
    "Correct the numbers": "数を直してください",
    "is aligned in two ways": "位置合わせが二通りあります",
    "Keep one, or name the pose of each": "一つだけ残すか、それぞれの姿勢を書いてください",
    "the EDL has no frame {frame}": "EDL にフレーム {frame} はありません",
    "It has 0 to {frames}": "あるのは 0〜{frames} です",
    "the EDL has no such pose": "EDL にその姿勢はありません",
    "It has 0 to {poses}": "あるのは 0〜{poses} です",
    "lacks columns: {lacking}": "列がありません: {lacking}",
    "holds no point pairs": "点の組がありません",
    "Add lines": "行を加えてください",
    # evaluation/questionnaire.py
    "a file of ratings": "評価のファイル",
    "The first line is {COLUMNS}": "1 行目は {COLUMNS} です",
    "lacks the column {lacking}": "列 {lacking} がありません",
    "the rating is {text}": "評価が {text} です",
    "Ratings are whole numbers from 1 to 5": "評価は 1〜5 の整数です",
    "names no {lacks}": "{lacks} がありません",
    "Complete or delete the line": "行を補うか、消してください",
    "participant {participant} rated {method} in video {video}, factor {factor}, twice": (
        "参加者 {participant} は映像 {video}、項目 {factor} で {method} を二度評価しています"
    ),
    "Keep one of the two lines": "二行のうち一行を残してください",
    "holds no ratings": "評価がありません",
    "Add lines of {COLUMNS}": "{COLUMNS} の行を加えてください",
    "has one method only, {methods}": "方法が {methods} 一つしかありません",
    "Rate at least two methods": "二つ以上の方法を評価してください",
    "and {missing} more": "ほか {missing} 件",
    "lacks the rating of {missing}{more}": "{missing} の評価がありません{more}",
    "The tests compare ratings within each participant: add them, or leave the participant out": (
        "検定は参加者ごとに評価を比べます。足りない評価を加えるか、その参加者を外してください"
    ),
    "{path}, video {video}, factor {factor}": "{path} の映像 {video}、項目 {factor}",
    "{count} participants": "参加者 {count} 人",
    "{count} participant": "参加者 {count} 人",
    "has {participants}": "{participants}です",
    "At least {LEAST} are needed: with fewer no outcome can be significant at 5 %": (
        "{LEAST} 人以上必要です。それより少ないと、どんな結果でも 5 % で有意になりません"
    ),
    # evaluation/results.py
    "there is no variant {name}": "変種 {name} はありません",
    "Measured are {there}": "測ってあるのは {there} です",
    "Measured are none": "測ったものはありません",
    "the results (evaluation.md)": "結果 (evaluation.md)",
    "is not the results of an evaluation ({SCHEMA})": "評価の結果 ({SCHEMA}) ではありません",
    "Make them with `mcsl evaluate EDL --json FILE`": "`mcsl evaluate EDL --json FILE` で作ってください",
    # evaluation/seen_through.py
    "Measuring what is seen through": "透視の量を測る",
    # simulation/families.py
    "there is no family {name}; there are {FAMILIES}": "系統 {name} はありません。あるのは {FAMILIES} です",
    "family {name} is named twice": "系統 {name} が二度あります",
    "families {by} and {name} want different things of {key}": (
        "系統 {by} と {name} は {key} に違うものを求めています"
    ),
    # simulation/ideal.py
    "ideal": "理想の映像",
    # simulation/photograph.py
    "the family photographic needs the photographs of scikit-image": (
        "系統 photographic には scikit-image の写真が必要です"
    ),
    "Run: pip install scikit-image": "実行してください: pip install scikit-image",
    # simulation/recorder.py
    "hdr must be one of {HDR}, got {value}": "hdr は {HDR} のいずれかですが、{value} です",
    "a recording is interlaced or HDR, not both": "収録はインターレースか HDR の一方だけです",
    "split_s must be half a second or more, got {value}": "split_s は 0.5 秒以上ですが、{value} です",
    "a clock goes on over parts: give split_s, too": ("時計を続けるにはファイルを分けます。split_s も指定してください"),
    "an interlaced picture's rows are a multiple of 4, got {size}": (
        "インターレースの画像の行数は 4 の倍数ですが、{size} です"
    ),
    "Choose {size}x{size2}": "{size}x{size2} を選んでください",
    # simulation/recording.py
    "cannot be written to ({strerror})": "書き込めません（{strerror}）",
    "scene": "場面",
    "film": "撮影",
    # simulation/scenario.py
    "{attribute_name} must lie between {low} and {high}, got {value}": (
        "{attribute_name} は {low}〜{high} ですが、{value} です"
    ),
    "{attribute_name} must be one of {choices}, got {value}": (
        "{attribute_name} は {choices} のいずれかですが、{value} です"
    ),
    "{attribute_name} must be (width, height), both even and 64 to 4096, got {value}": (
        "{attribute_name} は (幅, 高さ) で、どちらも 64〜4096 の偶数ですが、{value} です"
    ),
    "rate must lie between 1 and 240 frames a second, got {value}": (
        "フレームレートは毎秒 1〜240 フレームですが、{value} です"
    ),
    "movements must not be negative, got {movements}": "動きの数は負にできませんが、{movements} です",
    (
        "a movement needs 8 s, so {movements} need {movements2} s at least; the recording has {duration_s} s: "
        "make it longer or give their times yourself"
    ): (
        "動き 1 回に 8 秒かかるので、{movements} 回には {movements2} 秒以上必要ですが、収録は {duration_s} "
        "秒です。長くするか、動きの時刻を指定してください"
    ),
    (
        "movement (start_s={start}, length_s={length}) must last 0.2 s or more, lie within the recording's "
        "{duration_s} s and begin after the one before it has ended"
    ): (
        "動き (start_s={start}, length_s={length}) は 0.2 秒以上で、{duration_s} 秒の収録の中にあり、"
        "前の動きが終わった後に始まらなければなりません"
    ),
    # simulation/truth.py
    "its schema is not {SCHEMA}": "schema が {SCHEMA} ではありません",
    "its arrays lie beside it, not at {arrays}": "配列は {arrays} ではなく、その横になければなりません",
    "the truth's arrays": "真値の配列",
    "the truth of a simulated recording": "模擬収録の真値",
    "cannot be read as the truth of a simulated recording ({error})": "模擬収録の真値として読めません（{error}）",
    "Make the recording again with `mcsl simulate`": "`mcsl simulate` で収録を作り直してください",
    # cli/console.py: below the tables
    (
        "ITF in dB: over all pixels; over the valid ones, which both frames have from a camera; over those "
        "about the field, within {field} of the width of its middle. AvSpeed in pixels a frame: all points; "
        "those about the field. Pictures: {width}x{height}, {picture}{sampled}. Points within shots: "
        "{within_camera}. Points at switches: {at_switches}."
    ): (
        "ITF は dB で、全ピクセル、有効なピクセル（両方のフレームがカメラから得たもの）、"
        "術野の周り（幅の {field} 以内）の順です。AvSpeed は 1 フレームあたりのピクセル数で、"
        "全点、術野の周りの点の順です。画像: {width}x{height}、{picture}{sampled}。"
        "ショット内の点: {within_camera}。切り替えの点: {at_switches}。"
    ),
    ", switches alone": "、切り替えだけ",
    ", one in {every} pairs within shots": "、ショット内は {every} 組に一つ",
    "RootSIFT, mutual nearest neighbours (ratio 0.85), within 5 % of the width of the plane that a third share": (
        "RootSIFT、相互最近傍（比率 0.85）、三分の一が共有する平面から幅の 5 % 以内"
    ),
    "Shi-Tomasi corners followed by pyramidal Lucas-Kanade, there and back within 0.5 px": (
        "Shi-Tomasi の角をピラミッド型 Lucas-Kanade で追跡、往復で 0.5 px 以内"
    ),
    (
        "* significant at 5 %. Friedman: chi-square, effect Kendall's W. Pairs: Wilcoxon's signed ranks, "
        "two-sided; n who differ (equal ratings left out), the smaller sum of ranks, p exact unless marked "
        "~, effect the rank-biserial correlation."
    ): (
        "* は 5 % で有意。Friedman: カイ二乗、効果量は Kendall の W。"
        "組: Wilcoxon の符号付き順位、両側。n は評価が違う人（同じ評価は除く）、統計量は小さい方の順位和、"
        "p は ~ がなければ正確な値、効果量は順位双列相関。"
    ),
}
