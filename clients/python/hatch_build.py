"""Puts the command line into the wheel, as `cargo xtask wheel` asks for: `SEXTANT_WHEEL_PROGRAM` is the program,
`SEXTANT_WHEEL_PLATFORM` names the systems that run it.
"""

from __future__ import annotations

import os
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class ProgramHook(BuildHookInterface):  # type: ignore[type-arg]
    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        program = os.environ.get("SEXTANT_WHEEL_PROGRAM")
        if program:
            build_data["shared_scripts"] = {program: "sextant"}
            build_data["pure_python"] = False
            build_data["tag"] = f"py3-none-{os.environ['SEXTANT_WHEEL_PLATFORM']}"
