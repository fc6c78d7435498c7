"""XML as editors take it: text that XML can hold, file URLs, documents read without trust."""

from __future__ import annotations

import os
import re
import xml.etree.ElementTree as ET
from pathlib import Path, PureWindowsPath
from urllib.parse import unquote_to_bytes, urlsplit

from mcsl_core.errors import DocumentError
from mcsl_core.input_files import read_text

MOST_BYTES = 512 << 20  # a cut of a hundred thousand shots has a tenth of it
_MOST_DEPTH = 100  # readers go down into what is nested
_UNSAID = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")  # XML 1.0 has no other characters
_DRIVE = re.compile(r"/?[A-Za-z]:[/\\]")


def plain(text: str) -> str:
    """``text`` with a mark in the place of characters that XML and UTF-8 cannot hold."""
    return _UNSAID.sub("\ufffd", text)


def add(parent: ET.Element, tag: str, text: object = None, **attributes: object) -> ET.Element:
    """A child of ``parent``; attributes that are None are left out."""
    said = {name: plain(str(value)) for name, value in attributes.items() if value is not None}
    child = ET.SubElement(parent, tag, said)
    if text is not None:
        child.text = plain(str(text))
    return child


def number(value: float) -> str:
    """To a millionth, without a sign where that is 0."""
    return f"{round(value, 6) + 0.0:.15g}"


def document(root: ET.Element, doctype: str) -> bytes:
    """The whole document, indented, in UTF-8."""
    ET.indent(root)
    head = f'<?xml version="1.0" encoding="UTF-8"?>\n<!DOCTYPE {doctype}>\n'
    return head.encode() + ET.tostring(root, encoding="utf-8") + b"\n"


def read_xml(path: Path, root: str, what: str) -> ET.Element:
    """The root element of a document; DocumentError where it is no ``what``. Nothing that it refers to is opened."""
    remedy = f"Hand in {what} as the editor exported it"
    text = read_text(path, wanted=what, remedy=remedy, most=MOST_BYTES)
    if "<!ENTITY" in text:
        raise DocumentError("declares entities, which no editor writes", where=str(path), remedy=remedy)
    try:
        found = ET.fromstring(text.encode("utf-8", "replace"), ET.XMLParser(encoding="utf-8"))
    except ET.ParseError as error:
        raise DocumentError(f"is not XML ({error})", where=str(path), remedy=remedy) from error
    if found.tag != root:
        raise DocumentError(f"is {found.tag}, not {what}", where=str(path), remedy=remedy)
    if _deeper(found, _MOST_DEPTH):
        raise DocumentError(f"is nested more than {_MOST_DEPTH} deep", where=str(path), remedy=remedy)
    return found


def _deeper(root: ET.Element, most: int) -> bool:
    level = [root]
    for _ in range(most):
        level = [child for element in level for child in element]
    return bool(level)


def file_url(path: Path) -> str:
    """The URL of an absolute path: every character that a URL cannot hold is escaped."""
    return path.as_uri()


def path_of(url: str) -> str:
    """The path of a file URL, or of a bare path; of any system."""
    if not url.lower().startswith("file:"):
        return url
    parts = urlsplit(url.replace("?", "%3F").replace("#", "%23"))
    path = os.fsdecode(unquote_to_bytes(parts.path))
    if parts.netloc and parts.netloc != "localhost":
        return str(PureWindowsPath(f"//{parts.netloc}{path}"))
    return path[1:] if _DRIVE.match(path) and path.startswith("/") else path
