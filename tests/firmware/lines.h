// Lines as strings, sealed by the firmware's own code.
#pragma once

#include <string>

#include "output.h"

// All that waits in the queue, taken out.
inline std::string taken(firmware::Output& out) {
    std::string found;
    while (!out.empty()) found += static_cast<char>(out.take());
    return found;
}

// A body with its CRC and line end.
inline std::string sealed(const std::string& body) {
    firmware::Output out;
    out.begin().put(body.c_str()).finish();
    return taken(out);
}
