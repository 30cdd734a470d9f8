// The texts of the error table, each in flash.
#include "error_codes.h"

#include "progmem.h"

namespace firmware {
namespace {

#define FIRMWARE_ERROR_TEXTS(id, number, word, cause, cure) \
    const char kWord##id[] FLASH = word;                    \
    const char kCause##id[] FLASH = cause;                  \
    const char kCure##id[] FLASH = cure;
FIRMWARE_ERRORS(FIRMWARE_ERROR_TEXTS)
#undef FIRMWARE_ERROR_TEXTS

const char kNoText[] FLASH = "";

}  // namespace

ErrorText error_text(Error error) {
    switch (error) {
#define FIRMWARE_ERROR_CASE(id, number, word, cause, cure) \
    case Error::id:                                        \
        return ErrorText{kWord##id, kCause##id, kCure##id};
        FIRMWARE_ERRORS(FIRMWARE_ERROR_CASE)
#undef FIRMWARE_ERROR_CASE
        case Error::None:
            break;
    }
    return ErrorText{kNoText, kNoText, kNoText};
}

}  // namespace firmware
