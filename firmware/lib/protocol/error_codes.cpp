// The texts of the error table, each in flash.
#include "error_codes.h"

#include "progmem.h"

namespace firmware {
namespace {

#define FIRMWARE_ERROR_TEXTS(id, number, word, cause, cure) \
    const char kWord##id[] FLASH = word;                    \
    const char kCause##id[] FLASH = cause;                  \
    const char kCure##id[] FLASH = cure;                    \
    static_assert(sizeof(word) + sizeof(cause) + sizeof(cure) <= 150, "a verdict fits the queue");
FIRMWARE_ERRORS(FIRMWARE_ERROR_TEXTS)
#undef FIRMWARE_ERROR_TEXTS

const char kNoText[] FLASH = "";

// In the order of their numbers, which begin with 1; in flash, as a switch would be a table in RAM.
const ErrorText kTexts[] FLASH = {{kNoText, kNoText, kNoText},
#define FIRMWARE_ERROR_ROW(id, number, word, cause, cure) {kWord##id, kCause##id, kCure##id},
                                  FIRMWARE_ERRORS(FIRMWARE_ERROR_ROW)
#undef FIRMWARE_ERROR_ROW
};
static_assert(sizeof kTexts / sizeof kTexts[0] == static_cast<uint8_t>(Error::Output) + 1,
              "numbers leave no gap, and Output is the last one");

}  // namespace

ErrorText error_text(Error error) {
    ErrorText text;
#ifdef __AVR__
    memcpy_P(&text, &kTexts[static_cast<uint8_t>(error)], sizeof text);
#else
    text = kTexts[static_cast<uint8_t>(error)];
#endif
    return text;
}

}  // namespace firmware
