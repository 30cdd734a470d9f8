// Words are looked up in tables in flash; nothing is copied and nothing is changed in the line.
#include "command.h"

#include <string.h>

#include "crc16.h"
#include "fields.h"
#include "progmem.h"

namespace firmware {
namespace {

struct Word {
    const char* text;
    uint8_t length;

    bool is_flash(const char* flash_word) const {
        for (uint8_t i = 0; i < length; ++i) {
            if (flash_char(flash_word + i) != text[i]) return false;
        }
        return flash_char(flash_word + length) == '\0';
    }
    bool begins(const char* flash_word, uint8_t count) const {
        if (length != count) return false;
        for (uint8_t i = 0; i < length; ++i) {
            if (flash_char(flash_word + i) != text[i]) return false;
        }
        return true;
    }
    bool is_word() const { return text[0] >= 'a'; }
    bool is(const char* expected) const {
        return strlen(expected) == length && memcmp(expected, text, length) == 0;
    }
};

// `pose` with all its angles or `gait` with all its fields, and one too many.
const uint8_t kMaxWords = kMaxValues + 2;

struct Words {
    Word word[kMaxWords];
    uint8_t count;
};

Words split(const char* text, uint8_t length) {
    Words words;
    words.count = 0;
    for (uint8_t i = 0; i < length && words.count < kMaxWords;) {
        while (i < length && text[i] == ' ') ++i;
        const uint8_t start = i;
        while (i < length && text[i] != ' ') ++i;
        if (i > start) {
            words.word[words.count++] = Word{text + start, static_cast<uint8_t>(i - start)};
        }
    }
    return words;
}

#define FIRMWARE_VERB_TEXTS(id, word, min_fields, max_fields, help) \
    const char kHelp##id[] FLASH = word help;
FIRMWARE_VERBS(FIRMWARE_VERB_TEXTS)
#undef FIRMWARE_VERB_TEXTS

struct VerbText {
    const char* help;
    uint8_t length;  // of the word at its begin
    uint8_t min_fields, max_fields;
};

const VerbText kVerbTexts[kVerbs] FLASH = {
#define FIRMWARE_VERB_ROW(id, word, min_fields, max_fields, help) \
    {kHelp##id, sizeof(word) - 1, min_fields, max_fields},
    FIRMWARE_VERBS(FIRMWARE_VERB_ROW)
#undef FIRMWARE_VERB_ROW
};

const char* help_of(uint8_t verb) {
#ifdef __AVR__
    return static_cast<const char*>(pgm_read_ptr(&kVerbTexts[verb].help));
#else
    return kVerbTexts[verb].help;
#endif
}

const char kStraight[] FLASH = "straight";
const char kUnattended[] FLASH = "unattended";
const char kOff[] FLASH = "off";

int8_t hex_digit(char c) {
    if (c >= '0' && c <= '9') return static_cast<int8_t>(c - '0');
    if (c >= 'A' && c <= 'F') return static_cast<int8_t>(c - 'A' + 10);
    return -1;
}

// `*XXXX` behind a space at the end of the line: its value, or -1 if there is none.
int32_t trailing_crc(const char* line, uint8_t length) {
    if (length < 6 || line[length - 6] != ' ' || line[length - 5] != '*') return -1;
    int32_t value = 0;
    for (uint8_t i = 4; i > 0; --i) {
        const int8_t digit = hex_digit(line[length - i]);
        if (digit < 0) return -1;
        value = value * 16 + digit;
    }
    return value;
}

// `[-]digits[.digits]` in millionths; false if it is anything else or does not fit.
bool read_micro(const Word& word, int32_t& value_u) {
    const bool negative = word.length > 0 && word.text[0] == '-';
    uint32_t integer_part = 0, micro = 0, weight = 100000;
    uint8_t i = negative ? 1 : 0;
    bool any = false;
    for (; i < word.length && word.text[i] >= '0' && word.text[i] <= '9'; ++i, any = true) {
        integer_part = integer_part * 10 + static_cast<uint32_t>(word.text[i] - '0');
        if (integer_part > 2147) return false;
    }
    if (!any) return false;
    if (i < word.length && word.text[i] == '.') {
        any = false;
        for (++i; i < word.length && word.text[i] >= '0' && word.text[i] <= '9'; ++i, any = true) {
            if (weight == 0) return false;
            micro += static_cast<uint32_t>(word.text[i] - '0') * weight;
            weight /= 10;
        }
        if (!any) return false;
    }
    const uint32_t size = integer_part * 1000000 + micro;
    if (i != word.length || size > 2147483647UL) return false;
    value_u = negative ? -static_cast<int32_t>(size) : static_cast<int32_t>(size);
    return true;
}

Error read_value(const Word& word, const Field& field, int32_t& value_u) {
    if (!read_micro(word, value_u)) return Error::Number;
    return field.is_integer && value_u % 1000000 != 0 ? Error::Number : Error::None;
}

Refusal read_field(const Word& word, const Field& field, int32_t& value_u) {
    const Error error = read_value(word, field, value_u);
    if (error != Error::None || in_range(field, value_u)) return Refusal(error);
    return Refusal(Error::Range, field.name, value_u, field.low_u, field.high_u);
}

Refusal parse_gait(const Words& words, Command& command) {
    command.value_u[kOffset] = 0;
    for (uint8_t i = 1; i < words.count; ++i) {
        const uint8_t field = static_cast<uint8_t>(i - 1);
        const Refusal refusal =
            read_field(words.word[i], gait_field(field), command.value_u[field]);
        if (!refusal.none()) return refusal;
    }
    return Refusal();
}

// All joints at one angle.
Refusal parse_straight(const Words& words, Command& command) {
    if (!words.word[1].is_flash(kStraight)) return Refusal(Error::Number);
    if (words.count > 3) return Refusal(Error::Arguments);
    int32_t offset_udeg = 0;
    if (words.count == 3) {
        const Refusal refusal = read_field(words.word[2], gait_field(kOffset), offset_udeg);
        if (!refusal.none()) return refusal;
    }
    for (uint8_t i = 0; i < joint_count; ++i) command.value_u[i] = offset_udeg;
    return Refusal();
}

Refusal parse_pose(const Words& words, Command& command) {
    if (words.count > joint_count + 1) return Refusal(Error::Arguments);
    if (words.word[1].is_word()) return parse_straight(words, command);
    if (words.count != joint_count + 1) return Refusal(Error::Arguments);
    for (uint8_t i = 0; i < joint_count; ++i) {
        const Refusal refusal =
            read_field(words.word[i + 1], joint_angle_field(), command.value_u[i]);
        if (!refusal.none()) return refusal;
    }
    return Refusal();
}

Refusal parse_save(const Words& words, Command& command) {
    command.unattended = words.count == 2;
    const bool understood = !command.unattended || words.word[1].is_flash(kUnattended);
    return Refusal(understood ? Error::None : Error::Arguments);
}

// The controller looks at the limits, which depend on the board.
Refusal parse_set(const Words& words, Command& command) {
    command.lists = words.count == 1;
    if (command.lists) return Refusal();
    if (words.count != 3) return Refusal(Error::Arguments);
    for (uint8_t i = 0; i < kSettingCount; ++i) {
        const Field field = setting_field(i);
        if (!words.word[1].is(field.name)) continue;
        command.field = i;
        command.value_u[0] = 0;
        if (may_be_off(i) && words.word[2].is_flash(kOff)) return Refusal();
        return Refusal(read_value(words.word[2], field, command.value_u[0]));
    }
    return Refusal(Error::Name);
}

Refusal parse_trim(const Words& words, Command& command) {
    command.lists = words.count == 1;
    if (command.lists) return Refusal();
    if (words.count != 4) return Refusal(Error::Arguments);
    int32_t joint_u;
    if (!read_micro(words.word[1], joint_u)) return Refusal(Error::Number);
    if (joint_u < 1000000 || joint_u > joint_count * 1000000L || joint_u % 1000000 != 0) {
        return Refusal(Error::Name);
    }
    command.joint = static_cast<uint8_t>(joint_u / 1000000 - 1);
    for (uint8_t i = 0; i < kTrimFieldCount; ++i) {
        const Field field = trim_field(i);
        if (!words.word[2].is(field.name)) continue;
        command.field = i;
        return read_field(words.word[3], field, command.value_u[0]);
    }
    return Refusal(Error::Name);
}

}  // namespace

Refusal::Refusal(Error e, const char* name, int32_t value, int32_t low, int32_t high)
    : error(e), field(), value_u(value), low_u(low), high_u(high) {
    strncpy(field, name, sizeof field - 1);
}

bool ends_in_stop(const char* line, uint8_t length) {
    return length >= 4 && memcmp(line + length - 4, "stop", 4) == 0;
}

bool is_bare_bye(const char* line, uint8_t length) {
    return length == 3 && memcmp(line, "bye", 3) == 0;
}

Error check_line(const char* line, uint8_t length, Envelope& envelope) {
    const int32_t crc = trailing_crc(line, length);
    envelope = Envelope{line, length, crc >= 0, false, 0};
    if (envelope.has_crc) {
        envelope.length = static_cast<uint8_t>(length - 6);
        if (crc16(line, envelope.length) != static_cast<uint16_t>(crc)) return Error::Crc;
    }
    if (envelope.length == 0 || line[0] != '#') return Error::None;
    uint32_t number = 0;
    uint8_t i = 1;
    for (; i < envelope.length && i <= 5 && line[i] >= '0' && line[i] <= '9'; ++i) {
        number = number * 10 + static_cast<uint32_t>(line[i] - '0');
    }
    if (i == 1 || number > 65535 || i == envelope.length || line[i] != ' ') return Error::Sequence;
    envelope.has_number = true;
    envelope.number = static_cast<uint16_t>(number);
    envelope.body = line + i + 1;
    envelope.length = static_cast<uint8_t>(envelope.length - i - 1);
    return Error::None;
}

Refusal parse_command(const char* body, uint8_t length, Command& command) {
    const Words words = split(body, length);
    if (words.count == 0) return Refusal(Error::Command);
    uint8_t verb = 0;
    for (; verb < kVerbs; ++verb) {
        if (words.word[0].begins(help_of(verb), flash_u8(&kVerbTexts[verb].length))) break;
    }
    if (verb == kVerbs) return Refusal(Error::Command);
    const uint8_t fields = static_cast<uint8_t>(words.count - 1);
    if (fields < flash_u8(&kVerbTexts[verb].min_fields) ||
        fields > flash_u8(&kVerbTexts[verb].max_fields)) {
        return Refusal(Error::Arguments);
    }
    command = Command();
    command.verb = static_cast<Verb>(verb);
    switch (command.verb) {
        case Verb::Gait:
            return parse_gait(words, command);
        case Verb::Pose:
            return parse_pose(words, command);
        case Verb::Set:
            return parse_set(words, command);
        case Verb::Trim:
            return parse_trim(words, command);
        case Verb::Save:
            return parse_save(words, command);
        default:
            return Refusal();
    }
}

const char* verb_help(uint8_t verb) { return help_of(verb); }

}  // namespace firmware
