# SPDX-License-Identifier: GPL-3.0-or-later
"""The extension's texts in Japanese, by their English. No bpy; tests/addon/ui/test_translations.py keeps it so."""

JAPANESE: dict[str, str] = {
    # headings and labels
    "Recording": "収録",
    "Analyse": "解析",
    "Stages": "解析の各段階",
    "Shots": "ショット",
    "Look": "ルック",
    "Conform": "コンフォーム",
    "Render": "レンダリング",
    "Movement": "動きの検出",
    "Matching": "特徴点の対応",
    "Alignment": "位置合わせ",
    "Relief": "起伏",
    "Tracking": "追跡",
    "Occlusion": "遮蔽の判定",
    "Selection": "カメラの選択",
    "Centering": "センタリング",
    "Fill": "フィル",
    "Colour": "色合わせ",
    "Surface": "起伏合わせ",
    "See Through": "透視",
    "All": "全体",
    "Shot": "ショット",
    "On": "オン",
    "Off": "オフ",
    "Aid": "補助",
    "Camera": "カメラ",
    "Name": "名前",
    "Files": "ファイル",
    "Reference": "基準",
    "Preset": "プリセット",
    "Output": "出力",
    "Direction": "方向",
    "Up": "上へ",
    "Down": "下へ",
    "Next": "次",
    "Previous": "前",
    "Everything": "すべて",
    "Whole Shot": "ショット全体",
    "The star is the reference camera": "星印が基準カメラです",
    "Camera from the playhead on": "再生ヘッド以降のカメラ",
    "All pictures are exact": "すべて正確な映像です",
    "Conform first for exact pictures": "正確な映像にするには先にコンフォーム",
    "Decided by hand": "手動で決定",
    "By hand; the analysis chose {camera}": "手動で変更（解析の選択は {camera}）",
    "Field: drawn by hand": "術野: 手描き",
    "Field: nothing shows it, the middle is taken": "術野: 映像からは分かりません。中央を使います",
    "Analyse again to use the field": "術野を使うにはもう一度解析してください",
    "Centre by hand: {x:+.0f}, {y:+.0f} pixels": "手動の中心: {x:+.0f}, {y:+.0f} ピクセル",
    "{camera}, {length}": "{camera}、長さ {length}",
    "{count} files": "{count} ファイル",
    "Overrides: {count}": "手動変更: {count} 件",
    "{seconds} outstanding: the preview is shown there": "未コンフォーム {seconds}：そこはプレビュー表示です",
    "{seconds} of exact pictures fell away, because their decisions changed": (
        "決定が変わったため、正確な映像 {seconds} 分が外れました"
    ),
    "mcsl is not installed here": "mcsl がインストールされていません",
    "In the folder of its source run:": "mcsl のソースのフォルダーで実行:",
    "Default": "既定",
    "Default ({name})": "既定（{name}）",
    "What mcsl takes by itself": "mcsl が自分で選ぶもの",
    # buttons
    "Add Camera Files...": "カメラのファイルを追加...",
    "Remove Camera": "カメラを外す",
    "Move Camera": "カメラを移動",
    "Set Reference Camera": "基準カメラに設定",
    "Cancel": "中止",
    "Show Plugins": "プラグインを表示",
    "Build Timeline from EDL...": "EDL からタイムラインを作成...",
    "Build Proxies": "プロキシを作成",
    "Go to Cut": "カット点へ移動",
    "Go to the next cut of the programme": "プログラムの次のカット点へ移動",
    "Go to the previous cut of the programme": "プログラムの前のカット点へ移動",
    "There is no other cut": "ほかにカット点はありません",
    "Join Through-Edits": "スルーエディットを結合",
    "Take away cuts that nobody sees: between neighbouring strips of one camera that say the same": (
        "見えないカットを取り除きます。同じカメラ・同じ設定で隣り合うストリップの間です"
    ),
    "There is no such cut": "該当するカットはありません",
    "{count} cuts taken away": "カットを {count} 個取り除きました",
    "{count} shots under {frames} frames": "{frames} フレーム未満のショットが {count} 個あります",
    "Remove": "取り除く",
    "Bring Back": "元に戻す",
    "Leave the preview range (P) out of the video; without one the selected shots, or the one at the playhead": (
        "プレビュー範囲 (P) を完成映像から除きます。範囲がなければ選択中か再生ヘッドのショットです"
    ),
    "Deliver again what was removed of the preview range (P), or of the selected shots, or at the playhead": (
        "プレビュー範囲 (P)、選択中か再生ヘッドのショットから取り除いた部分を戻します"
    ),
    "That is removed already": "すでに取り除かれています",
    "{seconds} removed from the delivery": "{seconds} を完成映像から取り除きました",
    "Nothing is removed there": "そこから取り除かれたものはありません",
    "{seconds} delivered again": "{seconds} を完成映像に戻しました",
    "no frame of the programme is chosen": "本編のフレームが選ばれていません",
    "Set a preview range (P), select shots, or move the playhead": (
        "プレビュー範囲を設定 (P) するか、ショットを選択するか、再生ヘッドを動かしてください"
    ),
    "Removed: {seconds} in {count} places": "取り除いた部分: {count} か所、{seconds}",
    "Sound": "音声",
    "Automatic": "自動",
    "None": "なし",
    "The reference camera's": "基準カメラの音声",
    "This camera's microphone, in time with the pictures": "このカメラのマイクの音声を映像に合わせて使います",
    "A silent programme": "音声のない本編",
    "Whose sound the programme has": "本編に使う音声",
    "Choose the camera whose sound the programme has; sound that you changed yourself keeps your changes": (
        "本編に使う音声のカメラを選びます。手を加えた音声の変更はそのまま残ります"
    ),
    "Angles": "アングル",
    "Show all cameras at once beside the programme, the chosen one framed; again: the programme alone": (
        "すべてのカメラを本編の横に並べ、選ばれたカメラを枠で示します。もう一度押すと本編だけに戻ります"
    ),
    "Build a timeline first": "先にタイムラインを作ってください",
    "Pull Overrides into EDL": "手動変更を EDL に書き込む",
    "Switch Camera": "カメラを切り替え",
    "Go to Override": "手動変更へ移動",
    "Revert to Automatic": "自動に戻す",
    "Set Look": "ルックを設定",
    "Draw Field by Hand": "術野を手で描く",
    "Find Field Automatically": "術野を自動で探す",
    "Set Centre by Hand": "中心を手動で設定",
    "Centre Automatically": "中心を自動に戻す",
    "Reset Alignment": "位置合わせを元に戻す",
    "Set Output": "出力を設定",
    "Test": "テスト",
    "Copy Command": "コマンドをコピー",
    "Set Up mcsl...": "mcsl を設定...",
    # tooltips
    "Choose camera files; files named like cam1_000, cam1_001 are parts of one camera": (
        "カメラのファイルを選びます。cam1_000、cam1_001 のような名前は 1 台のカメラの続きです"
    ),
    "Take the chosen camera off the list; its files stay where they are": (
        "選んだカメラを一覧から外します。ファイルはそのまま残ります"
    ),
    "Move the chosen camera in the list; the order is that of the number keys": (
        "選んだカメラを一覧の中で動かします。順番は数字キーの順番になります"
    ),
    "Towards the first": "先頭の方へ",
    "Towards the last": "末尾の方へ",
    "Keep this camera's perspective in the programme": "このカメラの視点を本編の視点にします",
    "Its name; empty: the chosen one": "カメラの名前。空なら選んだカメラ",
    "The camera's files, played one after another": "カメラのファイル（順に続けて再生）",
    "What the buttons beside the list act on": "横のボタンの対象になるカメラ",
    "The camera whose perspective the programme keeps. Empty: the first": "本編の視点になるカメラ。空なら最初のカメラ",
    "The file that takes all decisions. Empty: edl.json beside the first camera file": (
        "すべての決定を収めるファイル。空なら最初のカメラのファイルと同じ場所の edl.json"
    ),
    "What is delivered": "納品の形式",
    "The video. Empty: beside the .blend, under its name": "動画ファイル。空なら .blend と同じ場所と名前",
    "The plugin that does this stage": "この段階を担うプラグイン",
    "Click to go to the shot": "クリックでショットへ移動",
    "The mcsl program. Empty: found by itself on PATH and where pip, pipx and uv install": (
        "mcsl のプログラム。空なら PATH と、pip・pipx・uv のインストール先から自動で探します"
    ),
    "Look for mcsl, run it once and show its version": "mcsl を探して一度動かし、バージョンを表示します",
    "Copy the command that installs mcsl, to be run in the folder of its source": (
        "mcsl をインストールするコマンドをコピーします。mcsl のソースのフォルダーで実行してください"
    ),
    "Show this extension's preferences, where the path of mcsl is set": (
        "この拡張機能の設定を開きます。mcsl の場所はそこで指定します"
    ),
    "Let mcsl decide: alignment, movements of the lamp, shots and centering; then build the timeline": (
        "位置合わせ、無影灯の動き、ショット、センタリングを mcsl が決め、タイムラインを作ります"
    ),
    "Stop; nothing half-written is left, and started again it carries on where it was": (
        "止めます。書きかけは残らず、もう一度始めると続きから進みます"
    ),
    "Ask mcsl which plugins there are for each stage": "各段階で使えるプラグインを mcsl に尋ねます",
    "Build the timeline of an EDL that mcsl made into this scene's empty sequencer": (
        "mcsl が作った EDL のタイムラインを、このシーンの空のシーケンサーに作ります"
    ),
    "Write what you decided in the timeline into the EDL, as overrides that analysis never touches": (
        "タイムラインで決めたことを手動変更として EDL に書き込みます。解析はそれに手を付けません"
    ),
    "Show this camera from the playhead to the end of the shot; Whole Shot: from its beginning": (
        "再生ヘッドからショットの終わりまでこのカメラにします。「ショット全体」なら最初から"
    ),
    "Which of the EDL's cameras, counted from 1": "EDL の何番目のカメラか（1 から）",
    "The camera's name, in place of its number": "番号の代わりのカメラの名前",
    "Change the whole shot in place of cutting it": "ショットを切らずに全体を変えます",
    "Set the selected camera strips back to where the analysis placed them": (
        "選択したカメラのストリップを、解析が置いた位置に戻します"
    ),
    "Go to the next stretch that an editor decided": "次の手動変更の区間へ移動します",
    "Go to the previous stretch that an editor decided": "前の手動変更の区間へ移動します",
    "Later than the playhead": "再生ヘッドより後",
    "Before the playhead": "再生ヘッドより前",
    "Set the shot at the playhead back to the automatic camera, look and centre": (
        "再生ヘッドのショットを、自動のカメラ・ルック・中心に戻します"
    ),
    "Set all shots back to the automatic cameras, looks and centres": (
        "すべてのショットを、自動のカメラ・ルック・中心に戻します"
    ),
    "All shots, not the one at the playhead": "再生ヘッドのショットだけでなく、すべてのショット",
    "Switch a visual aid on or off": "見やすくする補助をオン・オフします",
    "Switch it on, or off": "オンにするか、オフにするか",
    "For the whole programme, not the shot at the playhead": "再生ヘッドのショットだけでなく、本編全体",
    "Shift the surgical field to the middle of the picture": "術野を画面の中央に寄せます",
    "Fill what the camera does not see from the other cameras": "カメラに写らない所を、ほかのカメラの映像で埋めます",
    "Match each camera's colours to the reference camera's": "各カメラの色を基準カメラに合わせます",
    "Align the cameras by the relief of the field, not by a plane": "平面ではなく術野の起伏に沿ってカメラを合わせます",
    "Show what another camera sees under heads and arms": "頭や腕に隠れた術野を、別のカメラの映像で表示します",
    "for the whole programme": "本編全体",
    "for the shot at the playhead": "再生ヘッドのショット",
    "Click the middle of the field in the preview: the shot at the playhead is centred on it": (
        "プレビューで術野の中央をクリックすると、再生ヘッドのショットの中心がそこになります"
    ),
    "Pixels from the left of the picture": "画面の左からのピクセル数",
    "Pixels from the top of the picture": "画面の上からのピクセル数",
    "Centre the shot at the playhead by the analysis again": "再生ヘッドのショットの中心を、解析の結果に戻します",
    "Click the corners of the surgical field in the preview; the next analysis aligns, scores and centres by it": (
        "プレビューで術野の角をクリックします。次の解析は、それで位置合わせ・採点・センタリングをします"
    ),
    "Corners": "角",
    "Pixels of the picture shown: x,y x,y x,y": "表示中の画面のピクセル: x,y x,y x,y",
    "One More": "もう一つ",
    "Beside what is drawn already, not in its place": "すでに描いたものに加えます（置き換えません）",
    "Take the field that is drawn away: the next analysis finds it in the pictures again": (
        "描いた術野を消します。次の解析は、また映像から術野を探します"
    ),
    "Make the exact pictures of all that is outstanding, from the original files, and put them in place": (
        "未コンフォームの所の正確な映像を元のファイルから作り、タイムラインに置きます"
    ),
    "Render the programme to a video with the chosen preset, by Blender's own Render Animation": (
        "選んだプリセットで本編を動画にします（Blender のアニメーションレンダリング）"
    ),
    "Set this scene's output as the preset says, for Blender's own rendering and for blender -b FILE -a": (
        "このシーンの出力をプリセットに合わせます。Blender のレンダリングにも blender -b FILE -a にも効きます"
    ),
    # messages
    "mcsl {version} at {path}": "mcsl {version}（場所 {path}）",
    "; this extension belongs to {version}": "。この拡張機能は {version} 用です",
    "copied: {command}": "コピーしました: {command}",
    "Analysis": "解析",
    "Conforming": "コンフォーム中",
    "Exporting": "書き出し中",
    "Export for Another Editor...": "別の編集ソフト用に書き出す...",
    "Write the cut for another editor; `mcsl pull` reads back what is changed there": (
        "編集結果を別の編集ソフト用に書き出します。そこでの変更は `mcsl pull` で読み戻せます"
    ),
    "Format": "形式",
    "For Final Cut Pro and DaVinci Resolve": "Final Cut Pro と DaVinci Resolve 用",
    "For Premiere Pro and DaVinci Resolve": "Premiere Pro と DaVinci Resolve 用",
    "For DaVinci Resolve, Premiere Pro and others": "DaVinci Resolve、Premiere Pro など",
    "For everything else: one track of pictures": "そのほかのソフト用。映像トラックは一つです",
    "Exact Pictures": "正確な映像",
    "The conformed programme, a clip a shot; else the cameras' own files, roughly aligned": (
        "コンフォーム済みの番組をショットごとのクリップにします。オフなら各カメラの元のファイルを大まかに位置合わせして使います"
    ),
    "Next: shots, look and render appear here after the analysis": (
        "次: 解析が終わると、ショット・ルック・レンダリングがここに現れます"
    ),
    "Stage {number} of {count}: {stage}": "段階 {number}/{count}：{stage}",
    "{stage}, {time} left": "{stage}、残り {time}",
    "{camera} is shown already": "すでに {camera} を表示しています",
    "{camera} from frame {frame}": "フレーム {frame} から {camera}",
    "Strips set back: {count}": "元に戻したストリップ: {count}",
    "there is no camera {number}": "カメラ {number} はありません",
    "There are {count}: {names}": "あるのは {count} 台です: {names}",
    "starting": "開始しています",
    "stopping": "止めています",
    "putting it into the timeline": "タイムラインに置いています",
    "{title}: done": "{title}: 完了",
    "{title} stopped; started again, it carries on where it was": (
        "{title}: 止めました。もう一度始めると続きから進みます"
    ),
    "{title} runs already": "{title}: すでに動いています",
    "Wait, or cancel it": "終わるのを待つか、中止してください",
    "the plugins could not be read: {reason}": "プラグインを読めませんでした: {reason}",
    "Let the preview play smoothly, by small copies of the camera files beside the .blend; renders do not use them": (
        "プレビューを滑らかに再生するため、カメラのファイルの縮小版を .blend の横に作ります。レンダリングには使いません"
    ),
    "the file has no name yet": "ファイルにまだ名前がありません",
    "Save it: proxies lie beside it": "保存してください。プロキシはその横に置かれます",
    "proxies of {count} camera files": "カメラのファイル {count} 個のプロキシ",
    "Add camera files first": "先にカメラのファイルを追加してください",
    "No new camera file was chosen": "新しいカメラのファイルが選ばれていません",
    "There is a camera {name} already: rename the file": (
        "カメラ {name} はすでにあります。ファイルの名前を変えてください"
    ),
    "is missing": "が見つかりません",
    "is not a folder": "はフォルダーではありません",
    "Put it back, or take the camera off the list": "元に戻すか、カメラを一覧から外してください",
    "Choose another place for the EDL": "EDL の場所を選び直してください",
    "this scene's sequencer is not empty": "このシーンのシーケンサーは空ではありません",
    "Add a new scene and analyse there": "新しいシーンを追加して、そこで解析してください",
    "Add a new scene and build there": "新しいシーンを追加して、そこに作ってください",
    "the scene {name} is gone": "シーン {name} がなくなっています",
    "Build the timeline of {edl} by hand": "{edl} のタイムラインを手動で作ってください",
    "{shots} shots, {overrides} overrides": "ショット {shots}、手動変更 {overrides} 件",
    "{count} overrides written": "手動変更 {count} 件を書き込みました",
    "{count} overrides, as they were": "手動変更 {count} 件（変わりなし）",
    "There is no other override": "ほかに手動変更はありません",
    "The playhead is outside the programme": "再生ヘッドが本編の外にあります",
    "There is no shot at the playhead": "再生ヘッドにショットがありません",
    "frames {first} to {last} show no shot: {strip} is muted there. Unmute it, or delete it first": (
        "フレーム {first} から {last} にはショットが映りません：{strip} がミュートされています。"
        "ミュートを解除するか、先に削除してください"
    ),
    "automatic again; {count} overrides left": "自動に戻しました。残りの手動変更 {count} 件",
    "Open a preview beside the sequencer": "シーケンサーの横にプレビューを開いてください",
    "Frame": "フレーム",
    "Programme frame that the corners were seen in": "角をクリックした本編フレーム",
    "The preview shows one channel: set its channel to 0 to see the programme": (
        "プレビューは一つのチャンネルを表示しています。チャンネルを 0 にして本編を表示してください"
    ),
    "Click the middle of the field in the preview; Esc: leave it": "プレビューで術野の中央をクリック（Esc: やめる）",
    "Click the corners of the field; Enter: done; Backspace: take the last back; Esc: leave it": (
        "術野の角をクリック（Enter: 終わり、Backspace: 一つ戻す、Esc: やめる）"
    ),
    "Three corners or more make a field, in the picture and not in a line": (
        "術野には、画面の中で一直線でない三つ以上の角が必要です"
    ),
    "The field is drawn: analyse again to use it": "術野を描きました。使うにはもう一度解析してください",
    "{seconds} show the preview, not the exact pictures: conform first for those": (
        "{seconds} は正確な映像ではなくプレビューです。先にコンフォームしてください"
    ),
    "{seconds} of the programme show the preview, not the exact pictures. Conform before rendering": (
        "本編の {seconds} は正確な映像ではなくプレビューです。レンダリングの前にコンフォームしてください"
    ),
    "rendering to {path}": "レンダリング先: {path}",
    "there is no name for the video": "動画の名前が決まっていません",
    "Save the file, or choose an output": "ファイルを保存するか、出力を選んでください",
    "Choose another output": "出力を選び直してください",
    "the preset writes .{container} files": "このプリセットは .{container} を書き出します",
    "Name it so, or take another preset": "名前を合わせるか、別のプリセットを選んでください",
    # the presets, by their own files
    "Review, half size": "確認用（半分の大きさ）",
    "Small and quick to make: for looking at cuts and sending round.": "小さく速い：カットの確認や回覧に",
    "Full size for delivery; plays everywhere.": "納品用の全サイズ。どこでも再生できます。",
    "Full size for delivery in about half the space; slower to make, newer players only.": (
        "納品用の全サイズで約半分の容量。作るのは遅く、新しい再生ソフト向け。"
    ),
    "For further editing elsewhere: every frame by itself, 10 bit, uncompressed sound. Large.": (
        "ほかの編集ソフト用：全フレーム独立、10 ビット、非圧縮音声。大きなファイル。"
    ),
    "Lossless, for keeping: FFV1 pictures and FLAC sound in Matroska. Very large.": (
        "保存用の可逆圧縮：Matroska に FFV1 の映像と FLAC の音声。非常に大きなファイル。"
    ),
    "rendering stopped: nothing was written to {path}": "レンダリングを中止しました。{path} には何も書き込んでいません",
    "the video cannot take its name ({reason}); it lies at {path}": (
        "動画に名前を付けられません ({reason})。{path} にあります"
    ),
}
