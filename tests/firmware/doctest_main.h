#pragma once
// main() and a listener that prints "PASS case NAME" or "FAIL case NAME" for test_custom_runner.py.
#define DOCTEST_CONFIG_IMPLEMENT_WITH_MAIN
#if __has_include(<doctest.h>)
#include <doctest.h>  // as PlatformIO installs it
#else
#include <doctest/doctest.h>  // as distributions do
#endif

#include <cstdio>

struct CaseLines : doctest::IReporter {
    const doctest::TestCaseData* now = nullptr;
    explicit CaseLines(const doctest::ContextOptions&) {}
    void report_query(const doctest::QueryData&) override {}
    void test_run_start() override {}
    void test_run_end(const doctest::TestRunStats&) override { std::fflush(stdout); }
    void test_case_start(const doctest::TestCaseData& d) override { now = &d; }
    void test_case_reenter(const doctest::TestCaseData&) override {}
    void test_case_end(const doctest::CurrentTestCaseStats& s) override {
        std::printf("%s case %s\n", s.failure_flags ? "FAIL" : "PASS", now->m_name);
    }
    void test_case_exception(const doctest::TestCaseException&) override {}
    void subcase_start(const doctest::SubcaseSignature&) override {}
    void subcase_end() override {}
    void log_assert(const doctest::AssertData&) override {}
    void log_message(const doctest::MessageData&) override {}
    void test_case_skipped(const doctest::TestCaseData&) override {}
};
DOCTEST_REGISTER_LISTENER("case-lines", 1, CaseLines);
