"""Accelerations as C that CasADi loads: ``casadi.external``."""

from __future__ import annotations

import re

from ..model.c_header import c_header, package_in_code
from ..model.model import Model
from .for_casadi import check_name

OF_C = """
auto break case char const continue default do double else enum extern float for goto if inline int long main register
restrict return short signed sizeof static struct switch typedef union unsigned void volatile while
clearerr errno fclose feof ferror fflush fgetc fgetpos fgets fopen fprintf fputc fputs fread freopen fscanf fseek
fsetpos ftell fwrite getc getchar gets offsetof perror printf putc putchar puts remove rename rewind scanf setbuf
setvbuf snprintf sprintf sscanf stderr stdin stdout tmpfile tmpnam ungetc vfprintf vfscanf vprintf vscanf vsnprintf
vsprintf vsscanf
"""
"""Names that C has itself: its keywords, and those of <stdio.h>, which the file includes (C11, 6.4.1 and 7.21)."""

TEXT = """/* {name}: accelerations of {model} in flight, x[{p}] to u_dot[{n}], for casadi.external. By ccgen.
 * x: {columns} */
{header}
#define EXTERNAL {name}
#define EXTERNAL_MODEL ccgen_model_{package}
#define EXTERNAL_SETTINGS {package}_settings
#define EXTERNAL_T {t!r}
#define EXTERNAL_N {n}
#define EXTERNAL_INPUTS {inputs}
#include "casadi_external.h"
"""


def casadi_source(model: Model, name: str, columns: tuple[str, ...], t: float) -> str:
    """The text of a C file for the function ``name`` of a model with its parameters as they are now, at the time ``t``.

    Raises ``ValueError`` for names that CasADi or C does not take, and for a model in no folder.
    """
    check_name(name)
    header = c_header(model)
    assert model.folder is not None
    package = package_in_code(model.folder)
    own = re.search(rf"^(static|extern|enum) .*\b{name}\b", header, re.M)
    if own or name in OF_C.split() or re.match("ccgen|external|casadi|atomic", name.lower()):
        raise ValueError(f"name: found {name!r}, expected one that the C of {package} does not have itself")
    return TEXT.format(
        name=name,
        model=model.name,
        p=len(columns),
        columns=", ".join(columns),
        header=header,
        package=package,
        t=t,
        n=len(model.q_names),
        inputs=len(model.inputs),
    )
