"""Functions that are compiled for their compiled callers only: parts.

numba optimises every function and translates it to machine code, then does both again for its copy in each caller, and again
in theirs. A part stays as it was lowered: what Python calls is optimised and translated once, with all its parts.

Private names of numba without a public substitute: the steps of `finalize` in a library, and what is reduced for the disk.
"""

from typing import Any, NamedTuple

from llvmlite.binding import parse_bitcode  # type: ignore[import-untyped]
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler, CompileResult

_KIND = "part"


class _Part(JITCodeLibrary):  # type: ignore[misc]
    """Code for callers only: no machine code, hence no address, nor a place to tell numba's environment (`WholeCompiler`)."""

    def _optimize_final_module(self) -> None:
        pass

    def _finalize_final_module(self) -> None:
        self._finalize_dynamic_globals()
        self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:
        return 0

    @property
    def codegen(self) -> "_Part":
        return self

    def set_env(self, name: str, environment: Any) -> None:
        pass

    def serialize_using_object_code(self) -> tuple[str, str, bytes]:
        return self.name, _KIND, self._get_module_for_linking().as_bitcode()

    def unserialize_library(self, serialized: tuple[str, str, bytes]) -> "_Part":
        self._final_module = parse_bitcode(serialized[2])
        self._finalize_final_module()
        return self


class PartCompiler(Compiler):  # type: ignore[misc]
    """Compiles a part."""

    def __init__(self, typingctx: Any, targetctx: Any, library: Any, *others: Any) -> None:
        super().__init__(typingctx, targetctx, library or _Part(targetctx.codegen(), _KIND), *others)


class WholeCompiler(Compiler):  # type: ignore[misc]
    """Compiles what Python calls; tells its machine code the environments of its parts."""

    def compile_extra(self, func: Any) -> CompileResult:
        """As in numba."""
        result = super().compile_extra(func)
        for environment in result._find_referenced_environments():
            result.library.codegen.set_env(environment.env_name, environment)
        return result


class _Restoring(NamedTuple):
    """A target context whose `codegen` unpacks a part."""

    context: Any
    part: _Part

    @property
    def typing_context(self) -> Any:
        return self.context.typing_context

    def codegen(self) -> _Part:
        return self.part

    def get_executable(self, *arguments: Any) -> Any:
        return self.context.get_executable(*arguments)


def rebuilt(target_context: Any, reduced: tuple[Any, ...]) -> CompileResult:
    """The part or whole that was `reduced` (`CompileResult._reduce`)."""
    if reduced[0][1] != _KIND:
        return CompileResult._rebuild(target_context, *reduced)
    part = _Part(target_context.codegen(), _KIND)
    return CompileResult._rebuild(_Restoring(target_context, part), *reduced)._replace(target_context=target_context)
