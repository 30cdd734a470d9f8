# One line a test case, printed by the listener in doctest_main.h; nothing is downloaded.
import click
from platformio.test.result import TestCase, TestStatus
from platformio.test.runners.base import TestRunnerBase


class CustomTestRunner(TestRunnerBase):
    def on_testing_line_output(self, line):
        word, _, name = line.strip().partition(" case ")
        if word not in ("PASS", "FAIL"):
            click.echo(line, nl=False)
            return
        case = TestCase(name, TestStatus.PASSED if word == "PASS" else TestStatus.FAILED)
        self.test_suite.add_case(case)
        click.echo(case.humanize())
