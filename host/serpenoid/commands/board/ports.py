"""`serpenoid ports`: which serial port may be the robot."""

from __future__ import annotations

import click

from ...show.screen import say
from ..options import AS_JSON, show_json


@click.command()
@AS_JSON
def ports(as_json: bool) -> None:
    """List the serial ports: which may be the robot, and who has them open."""
    from ...robot.wire.ports import port_states, why_no_port

    found = port_states()
    if as_json:
        return show_json({"ports": found})
    for port in found:
        about = [port["device"], port["usb"], port["chip"] and f"likely a board ({port['chip']})"]
        about += [port["description"]]
        about += [f"open in {held['name']} ({held['pid']})" for held in port["held_by"]]
        about += [] if port["allowed"] else ["this user may not open it: try `serpenoid doctor`"]
        say("  ".join(part for part in about if part))
    if not any(port["chip"] for port in found):
        say(f"no board found by its USB id. {why_no_port()}", err=True)
