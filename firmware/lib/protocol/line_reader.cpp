// Collects the bytes of a line. A line that is too long or has a byte outside printable ASCII is
// read to its end, and its fault is reported there, once.
#include "line_reader.h"

namespace firmware {

void LineReader::clear() {
    length_ = 0;
    fault_ = kNothing;
}

LineReader::Event LineReader::push(uint8_t byte) {
    if (byte == '\n' || byte == '\r') {
        if (fault_ != kNothing) return fault_;
        return length_ > 0 ? kLine : kNothing;
    }
    if (byte < 0x20 || byte > 0x7E) {
        fault_ = kGarbled;
    } else if (length_ == line_capacity(joint_count)) {
        if (fault_ == kNothing) fault_ = kOverlong;
    } else {
        line_[length_++] = static_cast<char>(byte);
    }
    return kNothing;
}

}  // namespace firmware
