"""Compile the Arduino core for AVR with the flags that PlatformIO's own platform uses."""

import os

from SCons.Script import DefaultEnvironment

env = DefaultEnvironment()
board = env.BoardConfig()
package = env.PioPlatform().get_package_dir("framework-arduino-avr")
assert os.path.isdir(package or ""), "framework-arduino-avr is missing from the core dir"
core_src = os.path.join(package, "cores", board.get("build.core"))
variant = os.path.join(package, "variants", board.get("build.variant"))

common = ["-Os", "-Wall", "-ffunction-sections", "-fdata-sections", "-flto", "-mmcu=$BOARD_MCU"]
env.Append(
    CFLAGS=["-std=gnu11", "-fno-fat-lto-objects"],
    CXXFLAGS=["-std=gnu++11", "-fno-exceptions", "-fno-threadsafe-statics", "-fpermissive"],
    CCFLAGS=common,
    ASFLAGS=["-x", "assembler-with-cpp", *common],
    CPPDEFINES=[
        ("F_CPU", "$BOARD_F_CPU"),
        "ARDUINO_ARCH_AVR",
        ("ARDUINO", 10808),
    ],
    CPPPATH=[core_src, variant],
    LINKFLAGS=["-Os", "-mmcu=$BOARD_MCU", "-Wl,--gc-sections", "-flto", "-fuse-linker-plugin"],
    LIBS=["m"],
    LIBSOURCE_DIRS=[os.path.join(package, "libraries")],
)
env.Prepend(LIBS=[env.BuildLibrary(os.path.join("$BUILD_DIR", "FrameworkArduino"), core_src)])
