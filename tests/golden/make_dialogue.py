"""Write dialogue.txt: every byte of a conversation of host and board that follows PROTOCOL.md.

The answers are written here by hand; line numbers, CRCs and texts of errors are filled in.
`say` is a line of a person, `ask N` one of a host, `raw` bytes without a line end, `wait` seconds.
In dialogue.txt, `>` means bytes to the board, `<` a line from it, `~` seconds; \\n and \\xHH are
single bytes.
"""

from __future__ import annotations

import re
from binascii import crc_hqx
from pathlib import Path

HERE = Path(__file__).resolve().parent
PAGE = (HERE.parents[1] / "firmware" / "PROTOCOL.md").read_text()
ERRORS = {
    word: f"{cause}; {cure}"
    for word, cause, cure in re.findall(r"^\| `(\w+)` \| \d+ \| (.*?) \| (.*?) \|$", PAGE, re.M)
}
HELLO = (
    "hello: serpenoid fw=0.3.0 protocol=5 board=virtual joints=5 frame_us=20000 boot=0 "
    "reset=power settings=new silence=2"
)

SCRIPT = f"""
# The board starts.
{HELLO}

# A person types: neither number nor CRC.
say ping
ok: #-
say hello
{HELLO}
ok: #-
say load
err: #- empty
say pose 0 0 -115 0 0
err: #- range angle=-115 low=-114 high=114
say pose 95 0 0 0 0
err: #- range j1=95 low=-90 high=90
say pose straight 91
err: #- range offset=91 low=-90 high=90
say pose bent 10
err: #- number

# A host opens a session; from now on every line needs both.
ask 100 hello
{HELLO}
ok: #100
say ping
err: #? nocrc
seal idle
err: #? sequence
say #101 ping *0000
err: #? crc
ask 101 ping
ok: #101

# A repeated line, two lost ones, a late one.
ask 101 ping
ok: #101 again
ask 104 ping
ok: #104
ask 90 ping
err: #90 sequence

# Damage.
say #105 p\\x02ng
err: #? garbled
say #105 {"a" * 76}
err: #? overlong

# A stop: whatever stands around it, however long ago. What stands before it in its line is gone.
raw #105 pi
wait 0.2
raw \\xFF!
wait 0.05
ok: #!
raw #105 pi
wait 0.2
say stop
ok: #-
say #105 ping! *0000
ok: #!
err: #? crc

# Whole lines that cannot be obeyed.
ask 105 dance
err: #105 command
ask 106 gait 30
err: #106 arguments
ask 107 gait 30 80 fast
err: #107 number
ask 108 set colour 3
err: #108 name
ask 109 gait 95 0 1
err: #109 range alpha=95 low=0 high=90
ask 109 gait 95 0 1
err: #109 range again
ask 110 gait 60 80 5 40
err: #110 range j1=100 low=-90 high=90
ask 111 gait 90 80 20
err: #111 speed value=1800 high=500

# Settings and trims; a save, in which nothing may start.
ask 112 set silence 1.5
ok: #112
ask 113 set
set: angle_ramp value=60 low=1 high=360 unit=deg/s
set: rate_ramp value=5 low=0.1 high=100 unit=rad/s2
set: pose_speed value=45 low=1 high=360 unit=deg/s
set: servo_speed value=500 low=10 high=1000 unit=deg/s
set: silence value=1.5 low=0.1 high=600 unit=s
set: every value=1 low=0 high=1000 unit=frames
set: limp value=0 low=1 high=2000 unit=s
set: frame_ms value=20 low=3 high=20 unit=ms
set: oscillator value=25 low=22 high=28 unit=MHz
set: released value=0 low=0 high=2 unit=code
ok: #113
ask 114 trim 3 centre 1512
ok: #114
ask 115 trim
trim: #1 centre=1500 scale=573 dir=1 low=-90 high=90
trim: #2 centre=1500 scale=573 dir=1 low=-90 high=90
trim: #3 centre=1512 scale=573 dir=1 low=-90 high=90
trim: #4 centre=1500 scale=573 dir=1 low=-90 high=90
trim: #5 centre=1500 scale=573 dir=1 low=-90 high=90
ok: #115
ask 116 save
ask 117 gait 30 80 5
err: #117 saving
ok: #116
ask 117 gait 30 80 5
err: #117 saving again

# Motion.
ask 118 pose -20 10 0 -10 20
state: pose why=command
ok: #118
ask 119 save
err: #119 motion
wait 2
ask 120 trim 1 dir -1
err: #120 attached
t:400 j1:-20.00 j2:10.00 j3:0.00 j4:-10.00 j5:20.00 board_us=8020000 ph=0.000\
 p=1300,1600,1512,1400,1700 exec_us=0 late_us=0 clipped=0 st=pose
ask 121 pose -19.5 10.5 0.5 -9.5 20.5
ok: #121
wait 0.2
t:410 j1:-19.50 j2:10.50 j3:0.50 j4:-9.50 j5:20.50 board_us=8220000 ph=0.000\
 p=1305,1605,1517,1405,1705 exec_us=0 late_us=0 clipped=0 st=pose
ask 122 pose 9 -11 9 -11 9
ok: #122
wait 1
t:460 j1:9.00 j2:-11.00 j3:9.00 j4:-11.00 j5:9.00 board_us=9220000 ph=0.000\
 p=1590,1390,1602,1390,1590 exec_us=0 late_us=0 clipped=0 st=pose
ask 123 gait 30 80 5
state: gait why=command
ok: #123
raw !
wait 0.05
state: hold why=key
ok: #!
ask 123 gait 30 80 5
ok: #123 again
ask 124 gait 30.5 -80.25 0.5 -5
state: gait why=command
ok: #124
say stop
state: hold why=command
ok: #-
ask 125 pose 1 -2 3.5 0 10
state: pose why=command
ok: #125
ask 126 idle
state: idle why=command
ok: #126
ask 127 load
ok: #127
ask 128 defaults
ok: #128
ask 129 set silence off
ok: #129
ask 130 save
err: #130 unattended
ask 131 defaults
ok: #131

# The host falls silent.
ask 132 gait 30 80 5
state: gait why=command
ok: #132
state: safing why=silence
state: safe why=arrived
ask 133 pose straight
state: pose why=command
ok: #133
ask 134 stop
state: hold why=command
ok: #134
ask 135 idle
state: idle why=command
ok: #135

# A robot that is safe goes limp after a while, if it is told to.
ask 136 set limp 1
ok: #136
ask 137 gait 30 80 5
state: gait why=command
ok: #137
state: safing why=silence
state: safe why=arrived
state: idle why=limp

# The count of all that, and good-bye, by a host and by a person.
ask 138 status
counters: good=49 damaged=6 lost=2 dropped=0 rxfull=0
ok: #138
ask 139 bye
ok: #139
say ping
ok: #-
ask 7 hello
{HELLO}
ok: #7
say bye
ok: #-
say ping
ok: #-

# Lines end with LF, CR or both; empty ones do not count. 80 bytes are a line, other bytes are none.
# A line may take its time.
raw \\x0D\\n\\nping\\x0D\\nping\\n\\x0Dping\\x0D
ok: #-
ok: #-
ok: #-
say ping{" " * 76}
ok: #-
raw pi
wait 3
say ng
ok: #-
say a\\x00
err: #? garbled
say \\x07
err: #? garbled
say \\x1F
err: #? garbled
say \\x7F
err: #? garbled
say \\x80
err: #? garbled

# What is no command has its reason.
say Stopp
err: #- command
say gai 1 2 3
err: #- command
say gaits 1 2 3
err: #- command
say gait 1 2
err: #- arguments
say gait 1 2 3 4 5
err: #- arguments
say pose 1 2 3 4 5 6
err: #- arguments
say pose 1 2 3 4 5 6 7 8 9
err: #- arguments
say pose straight 1 2
err: #- arguments
say pose straight x
err: #- number
say ping 1
err: #- arguments
say save now
err: #- arguments
say set silenc 1
err: #- name
say set silence
err: #- arguments
say set every off
err: #- number
say set every 1.5
err: #- number
say trim 0 centre 1500
err: #- name
say trim 6 centre 1500
err: #- name
say trim 1.5 centre 1500
err: #- name
say trim 1 center 1500
err: #- name

# Numbers are millionths, exactly, or nothing.
say gait 30 80 1e1
err: #- number
say gait 30 80 +1
err: #- number
say gait 30 80 .
err: #- number
say gait 30 80 1.
err: #- number
say gait 30 80 .5
err: #- number
say gait 30 80 -
err: #- number
say gait 30 80 --1
err: #- number
say gait 30 80 0x1
err: #- number
say gait 30 80 1,5
err: #- number
say gait 30 80 nan
err: #- number
say gait 30 80 0.0000001
err: #- number
say gait 30 80 2147.483648
err: #- number
say gait 30 80 99999999999
err: #- number
say gait 30 80 1-
err: #- number
say gait 30 80 1.2.3
err: #- number

# Limits are inclusive, and a refusal names them.
say gait 90.000001 80 5
err: #- range alpha=90.000001 low=0 high=90
say gait 30 -180.000001 5
err: #- range beta=-180.000001 low=-180 high=180
say gait 30 80 0
err: #- range omega=0 low=0.01 high=30
say gait 30 80 -5
err: #- range omega=-5 low=0.01 high=30
say gait 0 -180 0.01 -90
state: gait why=command
ok: #-
say gait 16 180 30
ok: #-
say trim 1 centre 1510
err: #- motion
say stop
state: hold why=command
ok: #-
say defaults
err: #- attached
say load
err: #- attached
say idle
state: idle why=command
ok: #-
say set angle_ramp 0
err: #- range angle_ramp=0 low=1 high=360
say set servo_speed 1000.1
err: #- range servo_speed=1000.1 low=10 high=1000
say set silence 0.05
err: #- range silence=0.05 low=0.1 high=600
say set limp 0.9
err: #- range limp=0.9 low=1 high=2000
say set every 1001
err: #- range every=1001 low=1 high=1000
say set frame_ms 0
err: #- range frame_ms=0 low=3 high=20
say set released 3
err: #- range released=3 low=0 high=2
say trim 1 dir 0
err: #- range dir=0 low=-1 high=1
say trim 1 centre 2000
err: #- range pulse_ms=2.9 low=0.5 high=2.5
say gait 80 80 6.26
err: #- speed value=500.8 high=500
say gait 60 80 5 -40
err: #- range j1=-100 low=-90 high=90
say trim 2 high 30
ok: #-
say gait 40 80 5
err: #- range j2=40 low=-90 high=30
say pose 0 31 0 0 0
err: #- range j2=31 low=-90 high=30
say trim 4 low -35
ok: #-
say gait 30 80 5 -6
err: #- range j4=-36 low=-35 high=90
say trim 5 scale 600.5
ok: #-
say set angle_ramp 1
ok: #-
say set rate_ramp 00.5
ok: #-
say set pose_speed 89.999999
ok: #-
say set servo_speed 1000
ok: #-
say set silence 0
ok: #-
say set limp off
ok: #-
say set every 0
ok: #-
say set
set: angle_ramp value=1 low=1 high=360 unit=deg/s
set: rate_ramp value=0.5 low=0.1 high=100 unit=rad/s2
set: pose_speed value=89.999999 low=1 high=360 unit=deg/s
set: servo_speed value=1000 low=10 high=1000 unit=deg/s
set: silence value=0 low=0.1 high=600 unit=s
set: every value=0 low=0 high=1000 unit=frames
set: limp value=0 low=1 high=2000 unit=s
set: frame_ms value=20 low=3 high=20 unit=ms
set: oscillator value=25 low=22 high=28 unit=MHz
set: released value=0 low=0 high=2 unit=code
ok: #-
say   trim
trim: #1 centre=1500 scale=573 dir=1 low=-90 high=90
trim: #2 centre=1500 scale=573 dir=1 low=-90 high=30
trim: #3 centre=1500 scale=573 dir=1 low=-90 high=90
trim: #4 centre=1500 scale=573 dir=1 low=-35 high=90
trim: #5 centre=1500 scale=600.5 dir=1 low=-90 high=90
ok: #-
say defaults
ok: #-

# Numbers run over, an old line is not obeyed again, and what is no number is told.
ask 65531 hello
{HELLO}
ok: #65531
ask 65534 ping
ok: #65534
ask 65535 gait 30 80 5
state: gait why=command
ok: #65535
raw !
wait 0.06
state: hold why=key
ok: #!
ask 65535 gait 30 80 5
ok: #65535 again
ask 0 ping
ok: #0
ask 65535 gait 30 80 5
err: #65535 sequence
seal #65536 ping
err: #? sequence
seal # ping
err: #? sequence
seal #x ping
err: #? sequence
seal #-1 ping
err: #? sequence
seal #123456 x
err: #? sequence
seal #1
err: #? sequence
ask 1 idle
state: idle why=command
ok: #1
ask 2 bye
ok: #2
"""


def sealed(body: str) -> str:
    """Return the body with its CRC."""
    return f"{body} *{crc_hqx(body.encode(), 0xFFFF):04X}"


def answer(body: str) -> str:
    """Return a line of the board; an error has cause and cure from the table of PROTOCOL.md."""
    if body.startswith("err: "):
        body += f" - {ERRORS[body.split()[2]]}"
    return sealed(body)


def step(line: str) -> str:
    """Return the line of dialogue.txt for one line of the script."""
    word, _, fields = line.partition(" ")
    if word in ("", "#"):
        return line
    sent = {
        "say": lambda: f"> {fields}\\n",
        "seal": lambda: f"> {sealed(fields)}\\n",
        "ask": lambda: f"> {sealed('#' + fields)}\\n",
        "raw": lambda: f"> {fields}",
        "wait": lambda: f"~ {fields}",
    }
    return sent[word]() if word in sent else f"< {answer(line)}"


def dialogue_text() -> str:
    """Return the text of dialogue.txt."""
    rule = "# `>` to the board, `<` from it, `~` seconds; \\n, \\xHH bytes. By make_dialogue.py."
    return "\n".join([rule, *map(step, SCRIPT.splitlines())]) + "\n"


if __name__ == "__main__":
    (HERE / "dialogue.txt").write_text(dialogue_text())
