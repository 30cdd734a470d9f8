"""Build, size and upload AVR programs with the tools on PATH (for PlatformIO's atmelavr)."""

import os

from SCons.Script import AlwaysBuild, Builder, Default, DefaultEnvironment

env = DefaultEnvironment()
env.Replace(
    CC="avr-gcc",
    CXX="avr-g++",
    AS="avr-as",
    GDB="avr-gdb",
    AR="avr-gcc-ar",
    RANLIB="avr-gcc-ranlib",
    ARFLAGS=["rc"],
    OBJCOPY="avr-objcopy",
    SIZETOOL="avr-size",
    SIZECHECKCMD="$SIZETOOL -A -d $SOURCES",
    SIZEPRINTCMD="$SIZETOOL --mcu=$BOARD_MCU -C $SOURCES",
    SIZEPROGREGEXP=r"^(?:\.text|\.data|\.bootloader)\s+(\d+)",
    SIZEDATAREGEXP=r"^(?:\.data|\.bss|\.noinit)\s+(\d+)",
    PROGSUFFIX=".elf",
    UPLOADER="avrdude",
    UPLOADERFLAGS=["-p", "$BOARD_MCU", "-c", "$UPLOAD_PROTOCOL", "-b", "$UPLOAD_SPEED", "-D"],
    UPLOADCMD='$UPLOADER $UPLOADERFLAGS -P "$UPLOAD_PORT" -U flash:w:$SOURCES:i',
)
if env.get("PROGNAME", "program") == "program":
    env.Replace(PROGNAME="firmware")
to_hex = env.VerboseAction("$OBJCOPY -O ihex -R .eeprom $SOURCES $TARGET", "Building $TARGET")
env.Append(BUILDERS={"ElfToHex": Builder(action=to_hex, suffix=".hex")})

elf = env.BuildProgram()
hexfile = env.ElfToHex(os.path.join("$BUILD_DIR", "${PROGNAME}"), elf)
AlwaysBuild(env.Alias("nobuild", hexfile))
build = env.Alias("buildprog", hexfile, hexfile)
size = AlwaysBuild(env.Alias("size", elf, env.VerboseAction("$SIZEPRINTCMD", "Size of $SOURCE")))
find_port = env.VerboseAction(
    lambda target, source, env: env.AutodetectUploadPort(), "Looking for port"
)
upload = env.VerboseAction("$UPLOADCMD", "Uploading $SOURCE")
AlwaysBuild(env.Alias("upload", hexfile, [find_port, upload]))
Default([build, size])
