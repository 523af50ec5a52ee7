"""Public repositories of Structured Text whose share of accepted files is measured.

This repository does not contain these files. Fetch the repositories into one folder, each at the
commit of the table:

    git clone https://github.com/<name> <folder>/<owner>+<repository>
    git -C <folder>/<owner>+<repository> checkout <commit>

`RCX_REPOSITORIES` names the folder. If a repository is not in the folder, a message says so, and it
is left out.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from rcx_tools.bench.refusals import Reviewed
from structured_text.errors import InputError

__all__ = ["DIALECTS", "REPOSITORIES", "Repository", "how_to_get"]


@dataclass(frozen=True)
class Repository:
    """A public repository, with the files that belong to each of its programs.

    Attributes:
        name: Owner and repository.
        commit: The measured commit.
        tool: The tool for which the files are written.
        together: Patterns of files, folders or projects that together are one program.
        each: Patterns of files, folders or projects that are a separate program each.
        libraries: Patterns of files that belong to each of the separate programs in addition.
        device: The measured device of a CODESYS project that contains several devices.
        leaves_out: A pattern of paths that are not measured, with the reason in a comment.
        reviewed: Messages that a person has read and that do not show a gap.
        beyond: Constructs that the programs need and that the front end refuses by name. A
            repository with such constructs is measured without a target.
    """

    name: str
    commit: str
    tool: str
    together: tuple[str, ...] = ()
    each: tuple[str, ...] = ()
    libraries: tuple[str, ...] = ()
    device: str = ""
    leaves_out: str = ""
    reviewed: tuple[Reviewed, ...] = ()
    beyond: str = ""

    def folder(self, root: Path) -> Path:
        """Return the folder of the checkout."""
        return root / self.name.replace("/", "+")

    def programs(self, root: Path) -> Iterator[list[Path]]:
        """Yield the entries of each program.

        Raises:
            InputError: a pattern matches no file, so the checkout is not at the measured commit.
        """
        folder = self.folder(root)
        if self.together:
            yield [path for pattern in self.together for path in self._found(folder, pattern)]
        shared = [path for pattern in self.libraries for path in self._found(folder, pattern)]
        for pattern in self.each:
            yield from ([path, *shared] for path in self._found(folder, pattern))

    def _found(self, folder: Path, pattern: str) -> list[Path]:
        paths = [
            path
            for path in sorted(folder.glob(pattern))
            if not self.leaves_out or not re.search(self.leaves_out, path.as_posix())
        ]
        if not paths:
            raise InputError(
                f"{self.name} has nothing at {pattern}", hint=f"check out {self.commit}"
            )
        return paths


def how_to_get() -> str:
    """Return the lines for the user with the commands that fetch the repositories."""
    return "\n".join(
        f"git clone https://github.com/{one.name} {one.name.replace('/', '+')} && "
        f"git -C {one.name.replace('/', '+')} checkout {one.commit}"
        for one in REPOSITORIES
    )


#: The dialect of each tool.
DIALECTS = {
    "TwinCAT": "twincat",
    "CODESYS": "codesys",
    "CODESYS 2.3": "codesys",
    "SIMATIC AX": "ax",
    "TIA Portal": "tia",
    "Beremiz": "openplc",
    "Logix": "logix",
}
_TWINCAT, _CODESYS, _AX, _TIA = "TwinCAT", "CODESYS", "SIMATIC AX", "TIA Portal"
_BEREMIZ, _OSCAT, _LOGIX = "Beremiz", "CODESYS 2.3", "Logix"

#: The measured repositories. They were chosen for their tools and sizes. `beyond` marks a
#: repository with more gaps than the target allows.
REPOSITORIES = (
    Repository(
        "tcunit/TcUnit",
        "d447f95dff584cd9ae856784b189315a05ff93f1",
        _TWINCAT,
        together=("**/*.plcproj",),
    ),
    Repository(
        "stefanbesler/struckig",
        "0bc321d79dc40de268836eda6691347b1065f2d2",
        _TWINCAT,
        together=("Struckig/**/*.plcproj", "tests/**/*.plcproj"),
        each=("examples/**/*.plcproj",),
        libraries=("Struckig/**/*.plcproj",),
    ),
    Repository(
        "fisothemes/TwinCat-Dynamic-Collections",
        "d1317df9075d339b8cc6a6d1a9be42acdccc95de",
        _TWINCAT,
        together=("src/**/*.plcproj",),
    ),
    Repository(
        "pcdshub/lcls-twincat-general",
        "02ece2d1975fcf851e0f23f7799177b402036367",
        _TWINCAT,
        together=("**/*.plcproj",),
    ),
    Repository(
        "trofimich/TwinCAT.OpenFramework",
        "62cb3d27e8a539943719fc385c119ec0c5b9816e",
        _TWINCAT,
        # Two applications that have blocks with the same names, and the libraries of both. The
        # project "for old code storing" is left out, because it uses older libraries.
        each=("Sources/*.Samples/*.plcproj", "Sources/*.Tests/*.plcproj"),
        libraries=(
            "Sources/TwinCAT.OpenFramework.[!ST]*/*.plcproj",
            "Sources/TwinCAT.OpenFramework.T[ai]*/*.plcproj",
        ),
    ),
    Repository(
        "WitchCraftWorks/IEC61131-3-CDSV3",
        "b58814361e1bc4b83391c249d80681d6e264d37d",
        _CODESYS,
        each=("*/exports/*PLCopenXML.xml",),
    ),
    Repository(
        "MichielVanwelsenaere/HomeAutomation.CoDeSys3",
        "298b7bfd73761792e480cad00f342dc38d54a763",
        _CODESYS,
        each=("src/Exports/PLCopen.xml",),
        device="Wago_PFC200_G1_Lab",
    ),
    Repository(
        "simsum/oscat",
        "ccc5f45ebda082d0f87f50eadf23ff29e39cf9ba",
        _OSCAT,
        together=("*.EXP",),
    ),
    Repository(
        "simatic-ax/LAxisCtrl",
        "6452b7171f3c7274f5928c36134172782a5eb1d4",
        _AX,
        together=("src", "test"),
    ),
    Repository(
        "simatic-ax/conversion",
        "8b377b58f7cd83c330287c2385909e628f332b2e",
        _AX,
        together=("src", "test"),
    ),
    Repository(
        "simatic-ax/lpmlv2022",
        "116cf053fb24e6b49eb619ea1400b7372653a81a",
        _AX,
        together=("src", "test"),
    ),
    Repository(
        "simatic-ax/lacyccom-procedural",
        "bc06ee9e39749bb883dccf8ab5ee4f937695f211",
        _AX,
        together=("src", "test"),
    ),
    Repository(
        "simatic-ax/statemachine",
        "6dd29b09bbd1323956ac49719c31b56efd752b4d",
        _AX,
        together=("src", "test"),
    ),
    Repository(
        "germancorrederaserrano/NREL-ROSCO-Wind_Turbine-SCL-TIAPORTAL",
        "27704af99d428c7920d317a5a060bf3c0a3cbad6",
        _TIA,
        together=("*.scl",),
    ),
    Repository(
        "wonka929/OSCAT_OpenPLC",
        "7805d6df1fba4b0de666a1a720b51971c7af8afa",
        _BEREMIZ,
        each=("*/*/plc.xml",),
        reviewed=(
            Reviewed("this comment is never closed", "the text of the body is cut off in the file"),
        ),
    ),
    Repository(
        "Autonomy-Logic/STruCpp",
        "fb7980f5385d33ce60c87fb9395f15f55c6bc477",
        _BEREMIZ,
        together=("libs/sources/additional-function-blocks", "libs/sources/iec-standard-fb"),
        each=("examples/*.st",),
    ),
    Repository(
        "johnpuksta/l5x-lint",
        "4f03e2b6d71105f04258f069d9c36d74bfe1b0c3",
        _LOGIX,
        each=("tests/unit/data/valid/*/*.L5X",),
        reviewed=(
            Reviewed(r"aoiSigned.*has no data type", "the instruction is encrypted (EncodedData)"),
        ),
    ),
)
