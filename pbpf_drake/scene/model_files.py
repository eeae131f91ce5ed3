"""URDF and SDF files as robots come in ROS, made readable for Drake.

Their meshes may be STL or COLLADA files, and in packages that Drake doesn't
know. A file with such meshes is copied to the cache, and the copy names
converted meshes, by their whole paths.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
import hashlib
from pathlib import Path
from xml.dom import expatbuilder
from xml.dom.minidom import Document, Element
from xml.parsers.expat import ExpatError

from pydrake.multibody.parsing import PackageMap

from pbpf_drake.scene.mesh_files import CacheFolder, ReadableMesh, WriteWhole
from pbpf_drake.scene.model_packages import ResolveModelUrl

_ENDINGS = (".urdf", ".sdf")
# Elements of SDF that name other files and no mesh.
_OTHER_FILES = ("albedo_map",)
# How many of the things that were left out a sentence names.
_MOST_NAMED = 3


@dataclass
class ReadableModels:
    """Turns model files into files that Drake can read.

    Attributes:
        packages: the packages that are known.
        warnings: one sentence for everything that was left out.
        originals: the files that were copied, by the paths of their copies.
    """

    packages: PackageMap
    warnings: list[str] = field(default_factory=list)
    originals: dict[Path, Path] = field(default_factory=dict)

    def Make(self, path: Path, *, inside: tuple[Path, ...] = ()) -> Path:
        """Returns a file that Drake can read: this one, or a copy of it.

        Args:
            path: the model file, which exists. What is no URDF, SDF or XML is
                left to Drake, and so is what has nothing to change.
            inside: the files that include it.

        Raises:
            ValueError: a mesh that collides is missing or can't be read, a
                file includes itself, or xacro hasn't been run on it.
        """
        if path.suffix == ".xacro":
            raise ValueError(
                f"{path} is a xacro file; expected the URDF that it makes: "
                f"'xacro {path.name} > whole.urdf'"
            )
        document = _parse(path)
        if document is None:
            return path
        _refuse_expressions(path, document)
        if path in inside:
            raise ValueError(f"{path} includes itself, through {inside[-1]}")
        changed = self._ChangeMeshes(path, document)
        changed |= self._ChangeIncludes(path, document, inside)
        self._WarnOfXacro(path, document)
        if not changed:
            return path
        _name_whole_paths(path.parent, document)
        text = document.toxml()
        key = hashlib.sha256(text.encode()).hexdigest()[:24]
        copy = CacheFolder() / f"{path.stem[:60]}-{key}{path.suffix.lower()}"
        if not copy.is_file():
            WriteWhole(copy, text)
        self.originals[copy] = path
        return copy

    def OriginalNames(self, message: str) -> str:
        """Returns an error message with originals in the place of copies."""
        for copy, original in self.originals.items():
            message = message.replace(str(copy), str(original))
        return message

    def _ChangeMeshes(self, path: Path, document: Document) -> bool:
        """Converts all meshes; tells whether any differs from the file's."""
        changed = False
        left_out: dict[str, list[str]] = {}  # The links, by what is wrong.
        for role, link, element in _geometry_elements(document):
            try:
                for mesh in element.getElementsByTagName("mesh"):
                    changed |= self._Change(path, mesh, role)
            except ValueError as error:
                name = link.getAttribute("name")
                if role == "collision":
                    raise ValueError(
                        f"{path}: collision of link {name!r}: {error}"
                    ) from error
                left_out.setdefault(str(error), []).append(name)
                link.removeChild(element)
        if left_out:
            self.warnings.append(_left_out_sentence(path, left_out))
        return changed or bool(left_out)

    def _Change(self, path: Path, mesh: Element, role: str) -> bool:
        """Writes into a mesh element which file Drake should read instead."""
        url = _get_url(mesh)
        found = ResolveModelUrl(url, path.parent, self.packages)
        readable = ReadableMesh(found, hull=role == "collision")
        if readable == found and _drake_finds(url, self.packages):
            return False
        _set_url(mesh, str(readable))
        return True

    def _ChangeIncludes(
        self, path: Path, document: Document, inside: tuple[Path, ...]
    ) -> bool:
        changed = False
        for include in document.getElementsByTagName("include"):
            url = _get_url(include)
            try:
                found = ResolveModelUrl(url, path.parent, self.packages)
            except ValueError:  # Drake knows more kinds of these.
                continue
            readable = self.Make(found, inside=(*inside, path))
            if readable != found:
                _set_url(include, readable.as_uri())
                changed = True
        return changed

    def _WarnOfXacro(self, path: Path, document: Document) -> None:
        names = {
            element.tagName
            for element in document.getElementsByTagName("*")
            if element.tagName.startswith("xacro:")
        }
        if names:
            self.warnings.append(
                f"{path} has elements of xacro ({', '.join(sorted(names))}), "
                "which Drake leaves out; make a whole URDF of it by 'xacro "
                f"{path.name} > whole.urdf'"
            )


def _parse(path: Path) -> Document | None:
    """Returns an XML file's document, or None if it is none of a model.

    Prefixes needn't be declared, as Drake's parser doesn't ask for it either.
    """
    if path.suffix.lower() not in _ENDINGS or not path.is_file():
        return None
    try:
        return expatbuilder.parseString(path.read_bytes(), namespaces=False)
    except ExpatError:  # Drake says what is wrong, and where.
        return None


def _refuse_expressions(path: Path, document: Document) -> None:
    """Raises a ValueError if there is an expression that xacro replaces."""
    for part in ("link", "joint"):
        for owner in document.getElementsByTagName(part):
            for element in owner.getElementsByTagName("*"):
                for name, value in element.attributes.items():
                    if "${" in value:
                        raise ValueError(
                            f"{path}: {name} of {element.tagName} is "
                            f"{value!r}; expected what xacro makes of it: "
                            f"'xacro {path.name} > whole.urdf'"
                        )


def _geometry_elements(
    document: Document,
) -> Iterator[tuple[str, Element, Element]]:
    """Yields each collision and visual: its role, its link, and itself."""
    for role in ("collision", "visual"):
        for element in document.getElementsByTagName(role):
            link = element.parentNode
            if isinstance(link, Element):
                yield role, link, element


def _left_out_sentence(path: Path, left_out: dict[str, list[str]]) -> str:
    """Says which visuals are left out: the links, by what is wrong."""
    named = [
        f"{error} (link {', '.join(links)})"
        for error, links in left_out.items()
    ]
    if len(named) > _MOST_NAMED:
        named = [*named[:_MOST_NAMED], "and so on"]
    return (
        f"{path}: {sum(map(len, left_out.values()))} visuals are left out of "
        f"pictures: {'; '.join(named)}"
    )


def _drake_finds(url: str, packages: PackageMap) -> bool:
    """Tells whether Drake resolves a URL that leads somewhere."""
    scheme, found, rest = url.partition("://")
    if scheme in ("package", "model"):
        return packages.Contains(rest.partition("/")[0])
    return not (found or url.startswith(("file:", "~")))


def _get_url(element: Element) -> str:
    """Returns the file that an element of URDF or of SDF names."""
    if element.hasAttribute("filename"):
        return element.getAttribute("filename").strip()
    return _text(_uri_of(element)).strip()


def _set_url(element: Element, url: str) -> None:
    if element.hasAttribute("filename"):
        element.setAttribute("filename", url)
        return
    uri = _uri_of(element)
    if uri is not None:
        _set_text(uri, url)


def _uri_of(element: Element) -> Element | None:
    uris = element.getElementsByTagName("uri")
    return uris[0] if uris else None


def _text(element: Element | None) -> str:
    nodes = element.childNodes if element is not None else []
    return "".join(n.data for n in nodes if n.nodeType == n.TEXT_NODE)


def _set_text(element: Element, text: str) -> None:
    while element.firstChild is not None:
        element.removeChild(element.firstChild)
    element.appendChild(Document().createTextNode(text))


def _name_whole_paths(folder: Path, document: Document) -> None:
    """Replaces relative paths, as the copy lies elsewhere than the file."""
    for element in document.getElementsByTagName("*"):
        url = element.getAttribute("filename")
        if url and (folder / url).is_file():
            element.setAttribute("filename", str(folder / url))
        if element.tagName in ("uri", *_OTHER_FILES):
            url = _text(element).strip()
            if url and (folder / url).exists():
                _set_text(element, str(folder / url))
