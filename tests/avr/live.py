"""Run the firmware on a simulated board behind a pseudo-terminal, in real time, as a port."""

from __future__ import annotations

import signal
import subprocess
import tempfile
import time
from pathlib import Path

from avr.toolchain import MCUS, build_simulator


class LiveBoard:
    """A board on a port: `port` opens with pyserial (which resets it), but knows no DTR or RTS.

    boot_s: how long the boot loader keeps the program from running after each reset.
    speed: 1 is real time, 0 as fast as it goes.
    eeprom: a file that outlives the board; none keeps nothing.
    """

    def __init__(
        self,
        elf: Path,
        board: str = "uno",
        *,
        speed: float = 1.0,
        boot_s: float = 0.0,
        eeprom: Path | None = None,
        reset_on_open: bool = True,
        baud: int = 250_000,
    ):
        self._folder = tempfile.TemporaryDirectory(prefix="serpenoid-board-")
        self.port = str(Path(self._folder.name) / "tty")
        command = [str(build_simulator() / "simboard"), "--pty", self.port, "--mcu", MCUS[board]]
        command += ["--speed", str(speed), "--boot-s", str(boot_s), "--baud", str(baud)]
        command += ["--eeprom", str(eeprom)] if eeprom else []
        command += [] if reset_on_open else ["--no-reset-on-open"]
        self._process = subprocess.Popen([*command, str(elf)], stderr=subprocess.PIPE, text=True)
        self._await_port()

    def __enter__(self) -> LiveBoard:
        return self

    def __exit__(self, *_: object) -> None:
        self.unplug()

    def press_reset(self) -> None:
        """Press the reset button: the program starts again, the port stays open."""
        self._process.send_signal(signal.SIGUSR1)

    def hang(self) -> None:
        """Make the main program loop for ever; the watchdog has to notice."""
        self._process.send_signal(signal.SIGUSR2)

    def unplug(self) -> None:
        """Pull the cable: the port goes away, whoever has it open sees it closed."""
        if self._process.poll() is None:
            self._process.terminate()
        self._process.communicate(timeout=10)
        self._folder.cleanup()

    def _await_port(self, timeout_s: float = 5.0) -> None:
        end = time.monotonic() + timeout_s
        while not Path(self.port).exists():
            if self._process.poll() is not None or time.monotonic() > end:
                self._process.kill()
                said = self._process.communicate()[1]
                raise RuntimeError(f"the simulated board did not start: {said.strip()}")
            time.sleep(0.01)
