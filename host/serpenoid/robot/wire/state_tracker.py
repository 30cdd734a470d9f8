"""Which state the board may be in after what it was asked; no input or output here."""

from __future__ import annotations

from ...base.errors import RobotError, RobotUnattended, StateUnasked

STOPPED = frozenset({"hold", "idle"})  # a stop does nothing to servos that are limp
RESTING = frozenset({"hold", "idle", "safe"})


class StateTracker:
    """Follow the commands, and report each unexpected state once.

    Until the first command that moves anything, any state is right: an earlier program may have
    left it. Between a command's first copy and its verdict, the states before and after it are.
    """

    def __init__(self) -> None:
        self._states: frozenset[str] | None = None
        self._before: frozenset[str] | None = None
        self._halted = False
        self._asked: frozenset[str] = frozenset()
        self.last = "unknown"
        self.rested = True  # the board said so since the last stop

    def asking(self, text: str) -> None:
        """Note a command that goes out now."""
        self._before, self._halted, self._asked = self._states, False, self._states_of(text)
        if self._states is not None:
            self._states |= self._states_of(text)

    def halting(self) -> None:
        """Note a stop key that goes out now, whatever else is under way."""
        self._halted, self.rested = True, False
        if self._states is not None:
            self._states |= STOPPED

    def answered(self, text: str, accepted: bool) -> None:
        """Note the verdict on the command that went out last."""
        if not accepted:
            self._states = self._before
        elif states := self._states_of(text):
            self._states = states
        if self._halted and self._states is not None:
            self._states |= STOPPED

    @property
    def moves(self) -> bool:
        """Tell whether the robot may move, by what it said or by what it was asked for."""
        return bool({self.last, *(self._states or self._asked)} - RESTING)

    def hear(self, state: str) -> None:
        """Note a state that the board is in."""
        self.last = state
        self.rested = self.rested or state in RESTING

    def surprise(self, state: str, *, by_silence: bool = False) -> RobotError | None:
        """Return the error that the board is in a state nobody asked for, or None."""
        expected = self._states
        if state in expected if expected is not None else not by_silence:
            return None
        if by_silence or state in ("safing", "safe"):
            self._states = frozenset({"safing", "safe", "idle"})  # The way that silence leads.
            return RobotUnattended(
                "the board heard nothing from this program for its silence time and went to its "
                "safe pose; was the program or the computer asleep?"
            )
        self._states = frozenset({state})
        names = " or ".join(sorted(expected or ()))
        return StateUnasked(
            f"the board is in state {state!r}, asked for was {names!r}: another program or its own "
            "firmware changed that; look who else has the port (`serpenoid doctor`), start again"
        )

    def _states_of(self, text: str) -> frozenset[str]:
        """Return the states that a command leads to; none if it leaves the state as it is."""
        word = (text.split() or [""])[0]
        if word in ("stop", "!"):
            limp = self._states is None or "idle" in self._states
            return STOPPED if limp else STOPPED - {"idle"}
        return frozenset({word} & {"gait", "pose", "idle"})
