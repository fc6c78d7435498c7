"""What Apple's documentation of FCPXML 1.10 lets stand where, of the elements that mcsl writes.

Apple's own document type definition is downloaded from its site and not ours to hand on; Final Cut refuses a document
that breaks it. So the order of children, attributes and references are checked by hand.
"""

from __future__ import annotations

import re
from fractions import Fraction

from lxml import etree

_CLIP = "offset name start duration enabled lane"
_ANCHORED = "(asset-clip |mc-clip )*"
_CHILDREN = {
    "fcpxml": "resources library ",
    "resources": "(asset |format |media )*",
    "format": "",
    "asset": "(media-rep )+",
    "media-rep": "",
    "media": "multicam ",
    "multicam": "(mc-angle )*",
    "mc-angle": "(asset-clip |gap )*",
    "gap": "",
    "library": "(event )*",
    "event": "(project )*",
    "project": "sequence ",
    "sequence": "(note )?spine ",
    "note": "",
    "spine": "(asset-clip |mc-clip )*",
    "asset-clip": f"(adjust-transform )?(adjust-volume )?{_ANCHORED}(marker )*",
    "mc-clip": f"(adjust-volume )?(mc-source )*{_ANCHORED}(marker )*",
    "adjust-volume": "(param )*",
    "param": "(fadeIn )?(fadeOut )?",
    "fadeIn": "",
    "fadeOut": "",
    "mc-source": "",
    "adjust-transform": "",
    "marker": "",
}
_ATTRIBUTES = {  # those that must be there come first, before a stroke
    "fcpxml": "version|",
    "format": "id|name frameDuration width height",
    "asset": "id|name start duration hasVideo format videoSources hasAudio audioSources audioChannels audioRate",
    "media-rep": "src|kind",
    "media": "id|name",
    "multicam": "format|duration tcStart tcFormat",
    "mc-angle": "angleID|name",
    "gap": "duration|name offset start",
    "event": "|name",
    "project": "|name",
    "sequence": "format|duration tcStart tcFormat audioLayout audioRate",
    "asset-clip": f"ref|{_CLIP} format tcFormat srcEnable audioRole",
    "mc-clip": f"ref duration|{_CLIP} srcEnable",
    "mc-source": "angleID|srcEnable",
    "adjust-transform": "|position scale rotation",
    "adjust-volume": "|amount",
    "param": "name|value enabled",
    "fadeIn": "duration|type",
    "fadeOut": "duration|type",
    "marker": "start value|duration note",
}
_VALUES = {
    "tcFormat": "DF|NDF",
    "audioLayout": "stereo|surround",  # mono is in the definition, and refused
    "srcEnable": "all|audio|video",
    "hasVideo": "1",
    "hasAudio": "1",
    "lane": "-?[1-9][0-9]*",
    "type": "linear|easeIn|easeOut|easeInOut",
    "kind": "original-media|proxy-media",
}
_TIMES = ("start", "duration", "offset", "tcStart", "frameDuration")


def faults_of(root: etree._Element) -> list[str]:
    """What in a document is not as the documentation has it."""
    found = []
    ids = [element.get("id") for element in root.iter() if element.get("id")]
    found += [f"id {one} twice" for one in set(ids) if ids.count(one) > 1]
    for element in root.iter():
        tag = str(element.tag)
        if tag not in _CHILDREN:
            found.append(f"<{tag}> is not known")
            continue
        children = "".join(f"{child.tag} " for child in element)
        if not re.fullmatch(_CHILDREN[tag], children):
            found.append(f"<{tag}> holds {children}")
        must, _, may = _ATTRIBUTES.get(tag, "|").partition("|")
        given = set(element.attrib)
        found += [f"<{tag}> lacks {name}" for name in set(must.split()) - given]
        found += [f"<{tag}> has {name}" for name in given - {*must.split(), *may.split()}]
        for name, value in element.attrib.items():
            if name in _VALUES and not re.fullmatch(_VALUES[name], value):
                found.append(f"<{tag} {name}={value!r}>")
            if name in _TIMES and not _is_time(value):
                found.append(f"<{tag} {name}={value!r}> is no time")
            if name in ("ref", "format") and value not in ids:
                found.append(f"<{tag} {name}={value!r}> refers to nothing")
    return found


def _is_time(value: str) -> bool:
    """A rational of a 64-bit numerator and a 32-bit denominator, in seconds."""
    if not re.fullmatch(r"\d+(/[1-9]\d*)?s", value):
        return False
    time = Fraction(value[:-1])
    return time.numerator < 1 << 63 and time.denominator < 1 << 31
