"""Build one program with the host's own gcc (stand-in for PlatformIO's native platform)."""

from SCons.Script import AlwaysBuild, Default, DefaultEnvironment

env = DefaultEnvironment()
env.Replace(AR="gcc-ar", CC="gcc", CXX="g++", RANLIB="gcc-ranlib", SIZETOOL=None)
program = env.BuildProgram()
run = env.VerboseAction("$SOURCE $PROGRAM_ARGS", "Running $SOURCE")
AlwaysBuild(env.Alias("exec", program, run))
Default(env.Alias("buildprog", program, program))
