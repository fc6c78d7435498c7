"""Recordings, media files, sound and clocks."""

TEXTS: dict[str, str] = {
    # media/appending.py
    "is coded otherwise than the first piece": "最初の断片と符号化が違います",
    "Render it again": "もう一度レンダリングしてください",
    "holds {before} pictures where its name says {length}": "画像は {before} 枚ですが、名前では {length} 枚です",
    "the pieces could not be joined ({error})": "断片をつなげませんでした（{error}）",
    "Check whether the disk is full, and the pieces whole": (
        "ディスクがいっぱいでないか、断片が壊れていないか確認してください"
    ),
    # media/avi.py
    (
        "is an AVI whose index does not fit its pictures: bytes are missing inside it, and nothing says when "
        "what follows them was recorded"
    ): ("索引が画像と合わない AVI です。途中のバイトが欠けていて、その後がいつ収録されたか分かりません"),
    "Copy it again from the recorder, or leave it out": "レコーダーからコピーし直すか、外してください",
    # media/boxes.py
    "holds two films or more, as files joined end to end do, of which only the first can be seen": (
        "映像が二つ以上入っています。ファイルをそのままつないだもののようで、見えるのは最初の一つだけです"
    ),
    "Hand in the files it was joined from": "つなぐ前のファイルを渡してください",
    # media/colours.py
    "stored as {format_name}": "{format_name} で格納",
    "its colours are {name}, which mcsl cannot read": "色が {name} で、mcsl は読めません",
    "Convert it to BT.709, or export it so from the camera": (
        "BT.709 に変換するか、カメラからその形式で書き出してください"
    ),
    # media/hardware.py
    "there is no decoding hardware called {name}": "{name} というデコード用ハードウェアはありません",
    "This machine's FFmpeg has {built}": "このコンピューターの FFmpeg にあるのは {built} です",
    # media/opening.py
    "is {kind}; what it leads to is not opened": "{kind}です。その先は開きません",
    "is no regular file but a device, pipe or socket": "通常のファイルではなく、デバイスかパイプかソケットです",
    "Hand in the camera's video file": "カメラの動画ファイルを渡してください",
    "Hand in the camera's video file itself": "カメラの動画ファイルそのものを渡してください",
    "is no video file of a kind that is opened": "開ける種類の動画ファイルではありません",
    "Convert it to MP4, MOV or MKV, or leave it out": "MP4、MOV、MKV に変換するか、外してください",
    "cannot be opened as a video ({strerror})": "動画として開けません（{strerror}）",
    "It may be cut short or no video: copy it again from the recorder, or leave it out": (
        "途中で切れているか、動画ではないのかもしれません。レコーダーからコピーし直すか、外してください"
    ),
    "holds no video": "映像が入っていません",
    "Leave it out, or hand in the camera's video file": "外すか、カメラの動画ファイルを渡してください",
    "is a raw {format_name} stream, whose pictures have no timestamps": (
        "生の {format_name} ストリームで、画像に時刻がありません"
    ),
    (
        "Put it into a container with its rate, for example: mkvmerge -o {stem}.mkv --default-duration 0:25fps "
        "{path_name}"
    ): (
        "フレームレートを付けてコンテナーに入れてください。例: mkvmerge -o {stem}.mkv --default-duration 0:25fps "
        "{path_name}"
    ),
    # media/probing.py
    "{value} of {timed} pictures have no time of their own in this programme stream": (
        "このプログラムストリームでは、{timed} 枚のうち {value} 枚の画像に自分の時刻がありません"
    ),
    "Export it as MP4, or write it anew: ffmpeg -i {path_name} -crf 16 {stem}.mkv": (
        "MP4 で書き出すか、作り直してください: ffmpeg -i {path_name} -crf 16 {stem}.mkv"
    ),
    "its clock is set back after {at} s, as in files joined end to end": (
        "{at} 秒の後で時計が戻っています。ファイルをそのままつないだもののようです"
    ),
    (
        "Hand in the files it was joined from, or give it one clock: ffmpeg -i {path_name} -map 0 -c copy "
        "{stem}-joined.mkv"
    ): ("つなぐ前のファイルを渡すか、時計を一つにしてください: ffmpeg -i {path_name} -map 0 -c copy {stem}-joined.mkv"),
    "is an MXF file that was cut short, without the index that stands at its end": (
        "途中で切れた MXF ファイルで、末尾にあるはずの索引がありません"
    ),
    "Put what is left into another container: ffmpeg -i {path_name} -c copy {stem}.mkv": (
        "残っている部分を別のコンテナーに入れてください: ffmpeg -i {path_name} -c copy {stem}.mkv"
    ),
    "no picture in it": "画像が一枚もありません",
    "not one picture can be decoded ({reason})": "画像を一枚もデコードできません（{reason}）",
    # media/stripping.py
    "the video could not be freed of its metadata ({error})": "動画からメタデータを取り除けませんでした（{error}）",
    "Check whether the disk is full": "ディスクがいっぱいでないか確認してください",
    # media/tracks.py
    "without a decoder": "デコーダーなし",
    "sound track {position} ({kind})": "音声トラック {position}（{kind}）",
    # media/writing.py
    "{codec_context_name} knows no option {names}": "{codec_context_name} にはオプション {names} がありません",
    "a picture of {size} for a file of {size2}": "{size2} のファイルに {size} の画像です",
    "this file was opened without sound": "このファイルは音声なしで開かれています",
    "sound of {shape} channels for a file of {channels}": (
        "{channels} チャンネルのファイルに {shape} チャンネルの音声です"
    ),
    "there is no encoder {codec}": "{codec} というエンコーダーはありません",
    "{codec} is no {kind} encoder": "{codec} は{kind}のエンコーダーではありません",
    "a video's size is even and positive, got {size}x{size2}": "動画の大きさは正の偶数ですが、{size}x{size2} です",
    "Choose an even size": "偶数の大きさを選んでください",
    "sound has 1 or 2 channels, got {audio_channels}": "音声は 1 か 2 チャンネルですが、{audio_channels} です",
    "cannot encode with {codec} as {pixel_format} ({error})": (
        "{codec}、{pixel_format} でエンコードできません（{error}）"
    ),
    "Choose a codec, pixel format and options that this FFmpeg and the container know": (
        "この FFmpeg とコンテナーが対応するコーデック、ピクセル形式、オプションを選んでください"
    ),
    "writing failed after {frames} frames ({error})": "{frames} フレームの後で書き込みに失敗しました（{error}）",
    "Choose other encoder settings": "別のエンコード設定を選んでください",
    "no picture was written": "画像が一枚も書き込まれませんでした",
    "Choose a longer range": "もっと長い範囲を選んでください",
    "the file could not be finished ({error})": "ファイルを書き終えられませんでした（{error}）",
    # recording/cameras.py
    "there is no camera {name} to be the reference": "基準にするカメラ {name} がありません",
    "Choose one of {c_name}": "{c_name} から選んでください",
    "only one camera was found ({found})": "カメラが一台しか見つかりません（{found}）",
    "Hand in the files of at least two cameras": "二台以上のカメラのファイルを渡してください",
    "its files have different sizes: {w}": "ファイルの大きさが違います: {w}",
    "Hand them in as different cameras, or convert them to one size": (
        "別々のカメラとして渡すか、一つの大きさに変換してください"
    ),
    "camera {name}": "カメラ {name}",
    "cannot be taken: {fault}": "使えません: {fault}",
    "Leave it out, or convert it": "外すか、変換してください",
    "lasts until {seconds} s, at most {LONGEST_S} hours ({MOST_FRAMES} frames) are taken": (
        "{seconds} 秒まで続いています。{LONGEST_S} 時間（{MOST_FRAMES} フレーム）までです"
    ),
    "Leave that camera out, or cut the recording": "そのカメラを外すか、収録を切り分けてください",
    "camera {last}": "カメラ {last}",
    "{name} and {other} are one film, byte for byte; if one is a copy, take it out of the recording": (
        "{name} と {other} は 1 バイトも違わない同じ映像です。片方がコピーなら収録から外してください"
    ),
    "{name} and {other} are taken for two cameras; if they are parts of one, put both into a folder {name}": (
        "{name} と {other} を二台のカメラとして扱います。一台のカメラの続きなら、両方をフォルダー {name} "
        "に入れてください"
    ),
    "left out, as mcsl made it: {names}. To take it for a camera, name the camera files singly": (
        "mcsl が作ったものなので外しました: {names}。カメラとして使うには、カメラのファイルを一つずつ指定してください"
    ),
    (
        "{name} begins {begins_s} s before {reference}, the reference camera, with which the programme begins "
        "(--reference {name} would begin it earlier)"
    ): (
        "{name} は基準カメラ {reference} より {begins_s} 秒早く始まります。"
        "本編は基準カメラから始まります（--reference {name} なら早く始まります）"
    ),
    (
        "{reference}, the reference camera, ends at {own_s}; the programme goes on with others until {seconds}, "
        "where {last} ends. Its sound is {reference}'s unless another's is chosen"
    ): (
        "基準カメラ {reference} は {own_s} で終わり、本編はほかのカメラで {seconds} まで続きます（最後は "
        "{last}）。別に選ばなければ、音声は {reference} のものです"
    ),
    (
        "{name} ends at {end_s}, {seconds} s before the programme; if its recorder ran on, its last file may be "
        "cut short, or another is missing"
    ): (
        "{name} は {end_s} で終わり、本編より {seconds} 秒短いです。レコーダーが続いていたなら、"
        "最後のファイルが途中で切れているか、別のファイルが足りません"
    ),
    "Opening the cameras": "カメラのファイルを開く",
    (
        "{name}: by its name {path_name} follows {path_name2}, but it was made earlier ({created}, {created2}); "
        "the names were followed"
    ): (
        "{name}: 名前では {path_name} は {path_name2} の次ですが、作られたのはそれより前です（{created}、"
        "{created2}）。名前に従いました"
    ),
    "{name}: by their clock the files follow each other as {names}; their names were followed": (
        "{name}: 時計では {names} の順ですが、名前に従いました"
    ),
    "{name}: {files} files one after another, {path_name}": "{name}: 続きの {files} ファイル、{path_name}",
    "{name}: {path_name} asks players to show {asked_size} of its {coded_size} pixels; here all of them are shown": (
        "{name}: {path_name} は {coded_size} ピクセルのうち {asked_size} を表示するよう指定していますが、"
        "ここでは全体を表示します"
    ),
    # recording/changed_media.py
    "{path} of {camera_name} has changed since the analysis": "{camera_name} の {path} は解析の後で変わっています",
    # recording/contents.py
    "Reading the files": "ファイルを読む",
    # recording/damage.py
    "{camera_name}: {notes} more such stretches, see its gaps in the report": (
        "{camera_name}: ほかに {notes} 区間あります。報告書の欠落の欄を見てください"
    ),
    (
        "{camera} is damaged from {start} to {stop} (frames {piece}) inside its pictures, which no gap in the "
        "EDL says: another camera stands in there"
    ): (
        "{camera} は {start} から {stop}（フレーム {piece}）の画像の中が壊れています。EDL "
        "の欠落にはありませんが、そこでは別のカメラを使います"
    ),
    "Looking for damage": "損傷を探す",
    "Looking around damaged pictures": "損傷した画像の周りを調べる",
    "{path_name}, {start_s} to {stop_s}": "{path_name}、{start_s}〜{stop_s}",
    "{camera_name} has no picture in {where}: {why}": "{camera_name} は {where} に画像がありません: {why}",
    # recording/decoding.py
    "all but {left}": "{left} を除くすべて",
    "{count} files": "{count} ファイル",
    "{count} file": "{count} ファイル",
    "hardware ({hwaccel}) decodes {which}; the processor decodes {files}": (
        "ハードウェア ({hwaccel}) が {which}をデコードし、プロセッサーが {files}をデコードします"
    ),
    # recording/discovery.py
    "no recording was named": "収録が指定されていません",
    "Name a folder, or the camera files in order": "フォルダーか、カメラのファイルを順に指定してください",
    "two cameras are named {twice}": "{twice} という名前のカメラが二台あります",
    "Rename one of the files": "どちらかのファイルの名前を変えてください",
    "holds no video files": "動画ファイルがありません",
    "Name the folder the camera files lie in ({SUFFIXES}, ...)": (
        "カメラのファイル（{SUFFIXES} など）があるフォルダーを指定してください"
    ),
    # recording/disk_space.py
    "about {needed} ({needed2} an hour)": "約 {needed}（1 時間あたり {needed2}）",
    "{what} would take {takes}, and {free} are free": "{what}は {takes} になりますが、空きは {free} です",
    "Make room, or choose a folder on another disk": "空きを作るか、別のディスクのフォルダーを選んでください",
    ": it may not be enough": ": 足りないかもしれません",
    "{what} will take {takes} in {folder}; {free} are free{tight}": (
        "{what}は {folder} に {takes} になります。空きは {free} です{tight}"
    ),
    # recording/joining.py
    "{path_name} and {path_name2}": "{path_name} と {path_name2}",
    "{camera}: no picture for {pause} s from {at} on, between {names}": (
        "{camera}: {at} から {pause} 秒間、{names} の間に画像がありません"
    ),
    "{camera}: {names} overlap by {pause} s; the later one is shown": (
        "{camera}: {names} が {pause} 秒重なっています。後の方を表示します"
    ),
    # recording/sample_store.py
    "do not fit each other": "互いに合いません",
    "The samples": "サンプル",
    "the contents of samples": "サンプルの中身",
    "holds samples that are damaged": "壊れたサンプルがあります",
    "Delete it, or the folder it lies in, and run the same command again": (
        "それか、それが入っているフォルダーを消して、同じコマンドをもう一度実行してください"
    ),
    "Sampling the recording": "収録からサンプルを取る",
    # recording/sound_track.py
    "it has no sound": "音声がありません",
    "{tracks} is heard": "{tracks}を使います",
    "cannot be decoded": "はデコードできません",
    "is silent": "は無音です",
    "is much fainter": "はずっと小さい音です",
    "its channels cancel each other out, so channel {powers} alone is heard": (
        "チャンネルが打ち消し合うので、チャンネル {powers} だけを使います"
    ),
    "of its {powers} channels only {named} has sound": "{powers} チャンネルのうち音があるのは {named} だけです",
    # sync/audio.py
    "{name} has no sound": "{name} に音声がありません",
    "they have only {value} s of sound in common": "共通する音声が {value} 秒しかありません",
    "they are silent where they overlap": "重なる所が無音です",
    "their sound is shorter than 3 s": "音声が 3 秒より短いです",
    "one of them is silent": "片方が無音です",
    "nothing in their sound fits together": "音声に合う所がありません",
    "their sound fits together in several ways": "音声の合い方が何通りもあります",
    "Listening to the cameras": "カメラの音声を聞く",
    # sync/clock_fit.py
    "only {found} of {heard} windows have something in common": (
        "{heard} 個の区間のうち共通点があるのは {found} 個だけです"
    ),
    "only {agree} of {heard} windows agree on one clock": (
        "{heard} 個の区間のうち一つの時計で合うのは {agree} 個だけです"
    ),
    # sync/motion.py
    "{LEAST_RATE} pictures a second are too few": "毎秒 {LEAST_RATE} 枚の画像では足りません",
    "nothing moves in its pictures, or they are too short: {LEAST_S} s at least": (
        "画像の中に動くものがないか、短すぎます。{LEAST_S} 秒以上必要です"
    ),
    "what moves in its pictures fits no other camera": "画像の中で動くものが、ほかのどのカメラとも合いません",
    "what moves in its pictures fits the others in several ways": (
        "画像の中で動くものの合い方が、ほかのカメラと何通りもあります"
    ),
    # sync/motion_energy.py
    "Watching what moves": "動くものを見る",
    # sync/synchronise.py
    "there is no sync method {method}": "同期の方法 {method} はありません",
    "Choose one of {METHODS}": "{METHODS} から選んでください",
    "{name} is taken to start with {reference} ({why})": "{name} は {reference} と同時に始まるものとします（{why}）",
    (
        "{name}: its timecode begins as {reference}'s does, but its sound says {apart} ms other and was taken; "
        "--sync timecode goes by the timecode"
    ): (
        "{name}: タイムコードは {reference} と同じ始まりですが、音声では {apart} ms ずれているので、"
        "音声に従いました。--sync timecode ならタイムコードに従います"
    ),
    "{name}: its sound says {apart} ms other than its timecode, which was taken; --sync audio goes by the sound": (
        "{name}: 音声はタイムコードと {apart} ms ずれていますが、タイムコードに従いました。--sync audio "
        "なら音声に従います"
    ),
    # sync/timecode.py
    "{label} is no timecode": "{label} はタイムコードではありません",
    "{label} is no timecode at {rate} pictures a second": "{label} は毎秒 {rate} 枚のタイムコードではありません",
    "{label} drops labels, which does not fit {rate} pictures a second": (
        "{label} は番号を飛ばしていて、毎秒 {rate} 枚の画像に合いません"
    ),
    "{reference} counts {kinds}, {camera} {kinds2}": "{reference} は {kinds}、{camera} は {kinds2} で数えています",
    "all begin at {label}, as files do whose timecode nobody has set since the factory": (
        "すべて {label} で始まっています。出荷時からタイムコードを誰も合わせていないファイルのようです"
    ),
    "it cannot be told whether the labels count all {rate} pictures or every other one": (
        "番号が毎秒 {rate} 枚すべてを数えているのか、一つおきなのか分かりません"
    ),
    "by their timecodes {camera} begins {offset} s after {reference}: never together": (
        "タイムコードでは {camera} は {reference} の {offset} 秒後に始まり、同時に写る所がありません"
    ),
    "{camera} has no timecode": "{camera} にタイムコードがありません",
    "the files of {camera} do not follow each other: {gap} s are missing between two of them": (
        "{camera} のファイルが続いていません。二つの間に {gap} 秒足りません"
    ),
}
