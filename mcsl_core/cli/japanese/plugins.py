"""Plugins, and what they gave that they may not."""

TEXTS: dict[str, str] = {
    # hooks/guards.py
    "{method} raised {name}: {error}": "{method} が {name} を出しました: {error}",
    "an array of {dtype} and shape {shape}": "{dtype}、形 {shape} の配列",
    "{method} gave {value}, expected {name}": "{method} が返したのは {value} で、{name} が必要です",
    "Report it to the author of {package}, or choose another with --{stage}": (
        "{package} の作者に知らせるか、--{stage} で別のものを選んでください"
    ),
    # hooks/registry.py
    "there is no {noun} named {name}": "{name} という{noun}はありません",
    "Choose one of {known}, or install the plugin that brings it (`mcsl plugins` lists all)": (
        "{known} から選ぶか、それを含むプラグインをインストールしてください（`mcsl plugins` で一覧を表示）"
    ),
    "there is no {noun} named {name}, but {told}": "{name} という{noun}はありません。また、{told}",
    "Repair that plugin, or choose one of {known}": "そのプラグインを直すか、{known} から選んでください",
    "was made with the filler {made}, which is not installed": (
        "フィラー {made} で作られていますが、それがインストールされていません"
    ),
    "Install {package}, or analyse again with another --filler": (
        "{package} をインストールするか、別の --filler でもう一度解析してください"
    ),
    "Install it, or analyse again with another --filler": (
        "それをインストールするか、別の --filler でもう一度解析してください"
    ),
    "the EDL": "EDL",
    "two {stage} plugins are named {offer_name}": "{stage} プラグインが二つとも {offer_name} という名前です",
    "Uninstall one of them, or have its author rename it": (
        "どちらかをアンインストールするか、作者に名前を変えてもらってください"
    ),
    "{package} and {package2}": "{package} と {package2}",
    "cannot be imported: {name}: {error}": "インポートできません: {name}: {error}",
    "Repair or uninstall it: pip uninstall {package}": (
        "直すか、アンインストールしてください: pip uninstall {package}"
    ),
    "plugin {package} {version} ({point_value})": "プラグイン {package} {version}（{point_value}）",
    "Its hooks must be those of docs/hooks.md": "フックは docs/hooks.md のものでなければなりません",
    "plugin {package} {version}": "プラグイン {package} {version}",
    "{hook} failed: {name}: {error}": "{hook} が失敗しました: {name}: {error}",
    "Repair or uninstall it": "直すか、アンインストールしてください",
    "{hook} returned {result}": "{hook} が返したのは {result} です",
    "It must return a list": "リストを返さなければなりません",
    "{hook} offers the class {qualname}": "{hook} がクラス {qualname} を出しています",
    "It must offer objects: {qualname}()": "オブジェクト {qualname}() を出さなければなりません",
    "{hook} offers {implementation}, which lacks {lacking}": (
        "{hook} が出した {implementation} に {lacking} がありません"
    ),
    "{hook} offers {implementation}, which lacks a name": "{hook} が出した {implementation} に名前がありません",
    "See the protocol in docs/hooks.md": "docs/hooks.md のプロトコルを見てください",
    "{where} has been importing for {SLOW_S} s. If that is wrong, uninstall {package}": (
        "{where} のインポートが {SLOW_S} 秒続いています。おかしい場合は {package} をアンインストールしてください"
    ),
    # hooks/stage_guards.py
    "detect gave movement {movement_range}, which begins before {end}": (
        "detect が返した動き {movement_range} は {end} より前に始まっています"
    ),
    "detect gave a movement up to {end}, beyond the {frames} frames": (
        "detect が返した動きの終わり {end} は {frames} フレームを越えています"
    ),
    "detect gave a curve whose frames do not rise": "detect が返した曲線のフレームが昇順ではありません",
    "features gave the size {size} for a picture of {size2}": (
        "features が返した大きさは {size} ですが、画像は {size2} です"
    ),
    "features gave points that are not inside the picture of {size}": (
        "features が返した点が {size} の画像の中にありません"
    ),
    "features gave {descriptors} as descriptors, expected 2-D": (
        "features が返した記述子は {descriptors} で、2 次元でなければなりません"
    ),
    "features gave descriptors that are not of unit length": "features が返した記述子の長さが 1 ではありません",
    "match gave {pairs}, expected (M, 2) indices": "match が返したのは {pairs} で、(M, 2) の番号が必要です",
    "match gave {pairs}, expected integers": "match が返したのは {pairs} で、整数が必要です",
    "match gave an index outside of {count} points": "match が返した番号が {count} 個の点の外です",
    "match gave a point twice": "match が同じ点を二度返しました",
    "align gave neither a homography nor a reason for {missing}": (
        "align が {missing} のホモグラフィも理由も返しませんでした"
    ),
    "align gave {unknown}, which no camera is named": "align が返した {unknown} という名前のカメラはありません",
    "align gave both a homography and a reason for {twice}": (
        "align が {twice} のホモグラフィと理由の両方を返しました"
    ),
    "align gave no homography for the reference {reference}": (
        "align が基準 {reference} のホモグラフィを返しませんでした"
    ),
    "align gave {matrix} for {camera}": "align が {camera} に返したのは {matrix} です",
    "align gave {what} of {of}, expected all tied but one": (
        "align が返した{what}は {of} のもので、一つを除くすべてのつながったカメラのものが必要です"
    ),
    "align gave {value} as {what} of {camera}": "align が {camera} の{what}として返したのは {value} です",
    "estimate gave {nodes} as {what}, expected finite nodes": (
        "estimate が{what}として返したのは {nodes} で、有限の節点が必要です"
    ),
    "estimate gave gamma {shape}, confidence {shape2}": "estimate が返したのは gamma {shape}、信頼度 {shape2} です",
    "estimate gave a confidence outside of 0..1": "estimate が返した信頼度が 0〜1 の外です",
    "estimate gave {unknown}, which no camera is named": ("estimate が返した {unknown} という名前のカメラはありません"),
    "follow gave {found} views of {instants} instants": (
        "follow は {instants} 時点に対して {found} 個の位置を返しました"
    ),
    "follow gave {vector} as {what} at frame {frame}, expected 3 finite numbers": (
        "follow がフレーム {frame} の{what}として返したのは {vector} で、有限の数が 3 個必要です"
    ),
    "follow gave a view at frame {frame} with numbers of {FARTHEST} and more, in radians and distances": (
        "follow がフレーム {frame} に返した位置に {FARTHEST} 以上の数があります（ラジアンと距離）"
    ),
    "follow gave {zoom} as zoom at frame {frame}, expected a number": (
        "follow がフレーム {frame} のズームとして返したのは {zoom} で、数が必要です"
    ),
    "score gave {value} for camera {camera}, expected a number in 0..1": (
        "score がカメラ {camera} に返したのは {value} で、0〜1 の数が必要です"
    ),
    "scorer gave {scorer}, which has no score": "scorer が返した {scorer} に score がありません",
    "min_shot_s is {promised}, expected seconds of 0 or more": "min_shot_s は {promised} で、0 以上の秒数が必要です",
    "select chose camera {unknown}, expected one of {cameras}": (
        "select が選んだカメラは {unknown} で、{cameras} のいずれかが必要です"
    ),
    "centre gave {key}, expected (frame, dx, dy)": "centre が返したのは {key} で、(フレーム, dx, dy) が必要です",
    "centre gave a key at {key} of {frames} frames": ("centre が返したキーは {frames} フレームのうち {key} にあります"),
    "centre gave the keys' frames out of order at {frame}": (
        "centre が返したキーのフレームが {frame} で順番になっていません"
    ),
    "centre gave a shift of ({dx}, {dy}), larger than the programme": (
        "centre が返したずれ ({dx}, {dy}) は本編より大きいです"
    ),
    "fill gave a picture of {size}, expected {size2}": "fill が返した画像は {size} で、{size2} が必要です",
    "select gave shots with a gap or an overlap: {error}": ("select が返したショットに隙間か重なりがあります: {error}"),
    # hooks/stages.py
    "finds when the lamp moves": "無影灯の動きを見つける",
    "movement detector": "動き検出器",
    "finds the same places in two views": "二つの画像の同じ場所を見つける",
    "matcher": "対応付け器",
    "ties the views of a pose together": "一つの姿勢の画像をつなぐ",
    "aligner": "位置合わせ器",
    "finds the relief that the views share": "画像に共通する起伏を見つける",
    "relief estimator": "起伏推定器",
    "follows the lamp while it moves": "動く無影灯を追う",
    "lamp tracker": "無影灯追跡器",
    "says how much of the field shows": "術野がどれだけ見えるかを判定する",
    "occlusion detector": "遮蔽検出器",
    "chooses the camera of every moment": "各時点のカメラを選ぶ",
    "selector": "セレクター",
    "puts the surgical field in the middle": "術野を中央に置く",
    "centerer": "センタリング器",
    "fills what the warp leaves empty": "変形で空いた所を埋める",
    "filler": "フィラー",
    # hooks/watch.py
    "{who} has taken {total} s, for a recording of {lasts_s} s": (
        "{who} は {lasts_s} 秒の収録に {total} 秒かかりました"
    ),
    # mcsl plugins
    "Detects movements by whether each camera's static background still lies in place": (
        "各カメラの静止した背景が元の位置にあるかどうかで動きを検出します"
    ),
    "The paper's movement detector": "論文の動き検出器",
    "SIFT with the Hellinger kernel, mutual nearest neighbours with ratio": (
        "Hellinger カーネルの SIFT、比率付きの相互最近傍"
    ),
    "All cameras tied by the plane that serves the surgical field best: robust pairs, then all pairs together": (
        "術野に最も合う平面で全カメラをつなぎます。まず頑健に二台ずつ、次に全組を同時に"
    ),
    "A plane sweep over all views together: census, semi-global matching, a robust thin plate": (
        "全画像を合わせた平面スイープ: センサス、半大域的マッチング、頑健な薄板スプライン"
    ),
    "No relief: every pose stays one plane": "起伏なし: どの姿勢も一枚の平面のまま",
    "Holds every picture against the background of the poses at the movement's ends, from one end and the other": (
        "動きの両端の姿勢の背景に、各画像を両側から合わせます"
    ),
    "The share of the field's pixels that look as their background does": (
        "術野のピクセルのうち、いつもの背景どおりに見える割合"
    ),
    "The paper's kind of score: the share of the field's pixels that have the field's hue in that view": (
        "論文の方式の採点: 術野のピクセルのうち、その画像で術野の色相を持つ割合"
    ),
    "The programme that is worth most to watch, with a cost per switch and a hard minimum shot length": (
        "最も見る価値のある本編。切り替えごとに費用がかかり、最短のショット長を必ず守ります"
    ),
    "`ShortestPath` for a programme that sees through heads: with fewer switches, for a covered camera shows more": (
        "頭を透かして見る本編のための `ShortestPath`。隠れたカメラでもより多く見えるので、切り替えが減ります"
    ),
    "The camera that sees most at every sample, whatever the number of switches: the paper's greedy choice": (
        "切り替えの数を問わず、サンプルごとに最もよく見えるカメラ（論文の貪欲法）"
    ),
    "One camera throughout: the first of the recording, or the one it is made with": (
        "最初から最後まで一台のカメラ。収録の最初のカメラか、作る時に指定したカメラ"
    ),
    "Brings the middle of the field near the middle of the picture, and moves as seldom and as little as that takes": (
        "術野の中央を画面の中央近くに置き、動かす回数と量を必要なだけに抑えます"
    ),
    "Fills outside the camera's geometric footprint, softly over its edge, with what other cameras see there": (
        "カメラの幾何学的な範囲の外を、ほかのカメラに写るもので、縁をぼかしながら埋めます"
    ),
    "The paper's: pixels above 10, blurred by a Gaussian of 49 pixels, are the alpha over the reference camera": (
        "論文の方式: 10 を超えるピクセルを 49 ピクセルのガウシアンでぼかし、基準カメラに重ねるアルファにします"
    ),
}
