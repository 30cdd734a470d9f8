// The golden dialogue: what the controller says to each line, byte for byte.
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "controller.h"
#include "doctest_main.h"
#include "virtual_board.hpp"

using namespace firmware;

namespace {

const double kPatienceS = 10;

struct Step {
    char mark;  // '>' to the board, '<' a line from it, '~' seconds
    std::string text;
};

// "\n" and "\xHH" are written out in the file.
std::string bytes(const std::string& written) {
    std::string found;
    for (size_t i = 0; i < written.size(); ++i) {
        if (written[i] != '\\') {
            found += written[i];
        } else if (written.at(++i) == 'n') {
            found += '\n';
        } else {
            found += static_cast<char>(std::stoi(written.substr(i + 1, 2), nullptr, 16));
            i += 2;
        }
    }
    return found;
}

std::vector<Step> dialogue() {
    std::string here = __FILE__;
    here.erase(here.find_last_of('/') + 1);
    std::ifstream file(here + "../../golden/dialogue.txt");
    if (!file) throw std::runtime_error("cannot read tests/golden/dialogue.txt");
    std::vector<Step> steps;
    for (std::string line; std::getline(file, line);) {
        if (line.size() > 2 && line[1] == ' ' && line[0] != '#') {
            steps.push_back(Step{line[0], bytes(line.substr(2))});
        }
    }
    return steps;
}

bool timed(const std::string& line) {
    for (const char* word : {"t:", "status:", "timing:"}) {
        if (line.compare(0, std::string(word).size(), word) == 0) return true;
    }
    return false;
}

struct Bench {
    VirtualBoard board;
    std::string heard;

    Bench() { board.boot(Reset::Power); }
    void run(double seconds) {
        board.run(static_cast<uint64_t>(seconds * 1e6 + 0.5));
        heard += board.take();
    }
    // The next line that has come and is to be compared, or nothing.
    std::string next(const std::string& wanted) {
        for (size_t end; (end = heard.find('\n')) != std::string::npos;) {
            const std::string line = heard.substr(0, end);
            heard.erase(0, end + 1);
            if (line == wanted || !timed(line)) return line;
        }
        return "";
    }
    std::string await(const std::string& wanted) {
        for (double waited_s = 0; waited_s < kPatienceS; waited_s += 0.005) {
            const std::string line = next(wanted);
            if (!line.empty()) return line;
            run(0.005);
        }
        return "nothing";
    }
};

}  // namespace

TEST_CASE("the golden dialogue, byte for byte and nothing more") {
    Bench bench;
    int answers = 0;
    for (const Step& step : dialogue()) {
        if (step.mark == '>') {
            CHECK(bench.next("") == "");
            bench.board.put(step.text);
        } else if (step.mark == '~') {
            bench.run(std::stod(step.text));
        } else {
            REQUIRE(bench.await(step.text) == step.text);
            ++answers;
        }
    }
    bench.run(1);
    CHECK(bench.next("") == "");
    CHECK(answers > 70);
}
