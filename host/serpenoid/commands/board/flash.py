"""`serpenoid flash`: the firmware onto the board."""

from __future__ import annotations

from pathlib import Path

import click

from ...show.screen import say
from ..declare import option
from ..options import AS_JSON, show_json
from ..paths import FOLDER


@click.command()
@option(
    "--board", "Needed where the USB id does not tell.", choice=["uno", "nano", "nano_old", "mega"]
)
@option("--port", "Serial port; found by its USB id unless given.")
@option("--project", "Folder of platformio.ini; found from here unless given.", type=FOLDER)
@option("--joints", "How many joints the robot has: its links less one.", default=5)
@option(
    "--output",
    "Where servos are wired. pca9685 has run on a simulated chip only.",
    choice=["servo", "pca9685"],
    default="servo",
)
@AS_JSON
def flash(
    board: str | None,
    port: str | None,
    project: Path | None,
    joints: int,
    output: str,
    as_json: bool,
) -> None:
    """Build the firmware and put it on the board, by PlatformIO, then wait for its greeting."""
    from dataclasses import asdict

    from ...robot.tools.upload import flash as build_and_upload

    if output == "pca9685":
        say(
            "serpenoid: warning: the driver of the PCA9685 has run on a simulated chip only, never "
            "on a real one. Keep the horns off until the first power-on (docs/wiring.md) is done.",
            err=True,
        )
    hello = build_and_upload(
        board,
        port,
        project,
        lambda text: say(text.replace("\r", "\n"), nl=False, err=True),
        joints=joints,
        output=output,
    )
    if as_json:
        show_json(asdict(hello))
    else:
        say(
            f"the {hello.board} runs firmware {hello.firmware}, protocol {hello.protocol}; "
            "next: `serpenoid doctor`, then `serpenoid trim`"
        )
