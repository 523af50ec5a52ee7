"""Write small TwinCAT projects, for tests of several projects and their libraries."""

from __future__ import annotations

from pathlib import Path

__all__ = ["written_project"]

_OBJECT = """\
<TcPlcObject><{tag} Name="{name}"><Declaration><![CDATA[{head}]]></Declaration>
<Implementation>{body}</Implementation></{tag}></TcPlcObject>
"""
_TASK = """\
<TcPlcObject><Task Name="PlcTask"><CycleTime>10000</CycleTime><Priority>20</Priority>
<PouCall><Name>MAIN</Name></PouCall></Task></TcPlcObject>
"""


def written_project(
    folder: Path,
    objects: dict[str, str],
    settings: str = "",
    libraries: dict[str, str] | None = None,
    task: bool = True,
) -> Path:
    """Write a project and return the path of its .plcproj.

    `objects` maps a file name to the text of its object. A line `---` separates the declaration and
    the statements. With `--- LD` the body is in that language. `libraries` maps the title of each
    referenced library to its namespace.
    """
    folder.mkdir(parents=True)
    tags = {".TcPOU": "POU", ".TcDUT": "DUT", ".TcGVL": "GVL", ".TcIO": "Itf"}
    names = [*objects, *(["PlcTask.TcTTO"] if task else [])]
    for name, text in objects.items():
        head, _, body = text.partition("---")
        language, _, statements = body.partition("\n")
        inside = f"<{language.strip()}/>" if language.strip() else f"<ST>{statements}</ST>"
        tag = tags[Path(name).suffix]
        content = _OBJECT.format(tag=tag, name=Path(name).stem, head=head.strip(), body=inside)
        (folder / name).write_text(content, encoding="utf-8")
    if task:
        (folder / "PlcTask.TcTTO").write_text(_TASK, encoding="utf-8")
    references = "".join(
        f'<PlaceholderReference Include="{title}">\n<DefaultResolution>{title}, * (Someone)'
        f"</DefaultResolution>\n<Namespace>{space}</Namespace></PlaceholderReference>\n"
        for title, space in (libraries or {}).items()
    )
    items = "".join(f'<Compile Include="{name}"/>\n' for name in names)
    file = folder / f"{folder.name}.plcproj"
    file.write_text(
        f"<Project><PropertyGroup><Name>{folder.name}</Name>{settings}</PropertyGroup>\n"
        f"<ItemGroup>{items}</ItemGroup>\n<ItemGroup>\n{references}</ItemGroup></Project>\n",
        encoding="utf-8",
    )
    return file
