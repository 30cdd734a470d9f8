// Lines: reading them, sessions and sequence numbers, one verdict each.
#include "controller.h"
#include "progmem.h"

namespace firmware {
namespace {

const char kWhyKey[] FLASH = "key";
const char kWhyCommand[] FLASH = "command";

const uint8_t kBytesPerPass = 64;
const uint32_t kKeyPauseUs = 20000;
const uint32_t kUnfinishedUs = 100000;

}  // namespace

void Controller::receive(uint32_t now_us) {
    for (uint8_t n = 0; n < kBytesPerPass && waiting_ == LineReader::kNothing; ++n) {
        const int16_t byte = hardware_.receive();
        if (byte < 0) return;
        last_byte_us_ = now_us;
        waiting_ = reader_.push(static_cast<uint8_t>(byte));
    }
    // A stop does not wait for room or for a report; its verdict may.
    if (waiting_ == LineReader::kLine && is_bare_stop(reader_.data(), reader_.length())) {
        stop(reader_.data()[0] == '!' ? kWhyKey : kWhyCommand);
    }
}

// What a pause means: after the stop key, a stop; inside a session, that the rest is not coming.
void Controller::watch_pause(uint32_t now_us) {
    if (waiting_ != LineReader::kNothing || !reader_.partial()) return;
    const uint32_t pause_us = now_us - last_byte_us_;
    if (reader_.ends_with_stop_key() && pause_us > kKeyPauseUs) {
        stop(kWhyKey);
        reader_.clear();
        reader_.push('!');
        waiting_ = LineReader::kLine;
    } else if (session_ && pause_us > kUnfinishedUs) {
        waiting_ = LineReader::kGarbled;
    }
}

void Controller::accept_waiting() {
    if (waiting_ == LineReader::kNothing || report_ != Report::None) return;
    if (hardware_.room() < kRoom) return;
    if (waiting_ == LineReader::kLine) {
        accept_line();
    } else if (waiting_ == LineReader::kOverlong) {
        refuse_damaged(Error::Overlong, counters_.overlong);
    } else {
        refuse_damaged(Error::Garbled, counters_.garbled);
    }
    reader_.clear();
    waiting_ = LineReader::kNothing;
}

void Controller::accept_line() {
    if (is_bare_stop(reader_.data(), reader_.length())) {
        tag_ = Tag{reader_.data()[0] == '!' ? '!' : '-', 0};
        count(counters_.good);
        silent_frames_ = 0;
        return verdict(tag_, Refusal());
    }
    Envelope envelope;
    const Error damage = check_line(reader_.data(), reader_.length(), envelope);
    if (damage == Error::Crc) return refuse_damaged(damage, counters_.crc);
    if (session_ && !envelope.has_crc) return refuse_damaged(Error::NoCrc, counters_.nocrc);
    if (damage == Error::Sequence || (session_ && !envelope.has_number)) {
        return refuse_damaged(Error::Sequence, counters_.sequence);
    }
    accept_body(envelope);
}

void Controller::accept_body(const Envelope& envelope) {
    Command command;
    Refusal refusal = parse_command(envelope.body, envelope.length, command);
    const bool greets = refusal.none() && command.verb == Verb::Hello;
    tag_ = Tag{envelope.has_number ? '#' : '-', envelope.number};
    if (session_ && !greets && !in_order(envelope)) return;
    last_number_ = envelope.number;
    if (refusal.none()) refusal = obey(command);
    if (greets && envelope.has_crc && envelope.has_number) session_ = true;
    count(counters_.good);
    if (envelope.has_crc || refusal.none()) silent_frames_ = 0;
    last_error_ = refusal.error;
    if (refusal.none() && report_ != Report::None) return;  // the verdict follows the report
    if (refusal.none() && command.verb == Verb::Save) {
        save_tag_ = tag_;  // the verdict follows the save
        return;
    }
    verdict(tag_, refusal);
}

// Whether a numbered line of a session is to be obeyed; if not, it has been answered here.
bool Controller::in_order(const Envelope& envelope) {
    const uint16_t ahead = static_cast<uint16_t>(envelope.number - last_number_);
    silent_frames_ = 0;
    if (ahead >= 1 && ahead < 0x8000) {
        count(counters_.lost, static_cast<uint16_t>(ahead - 1));
        return true;
    }
    count(counters_.repeated);
    const bool save_pending = store_.saving() && save_tag_.number == envelope.number;
    if (ahead == 0 && !save_pending) verdict(tag_, Refusal(last_error_), true);
    if (ahead != 0) verdict(tag_, Refusal(Error::Sequence));
    return false;
}

void Controller::refuse_damaged(Error error, uint16_t& counter) {
    count(counter);
    tag_ = Tag{'?', 0};
    verdict(tag_, Refusal(error));
}

void Controller::finish_save() {
    bool good;
    if (!store_.step(good)) return;
    const Error error = good ? Error::None : Error::Eeprom;
    if (save_tag_.number == last_number_) last_error_ = error;
    verdict(save_tag_, Refusal(error));
}

void Controller::verdict(const Tag& tag, const Refusal& refusal, bool again) {
    line_.clear();
    line_.put_flash(refusal.none() ? FLASH_TEXT("ok: #") : FLASH_TEXT("err: #"));
    if (tag.kind == '#') {
        line_.put_unsigned(tag.number);
    } else {
        line_.put(tag.kind);
    }
    const ErrorText text = error_text(refusal.error);
    if (!refusal.none()) line_.put(' ').put_flash(text.word);
    if (again) line_.put_flash(FLASH_TEXT(" again"));
    if (refusal.field[0] != '\0') {
        line_.put(' ').put(refusal.field).put('=').put_micro(refusal.value_u);
        if (refusal.error == Error::Range)
            line_.put_flash(FLASH_TEXT(" low=")).put_micro(refusal.low_u);
        line_.put_flash(FLASH_TEXT(" high=")).put_micro(refusal.high_u);
    }
    if (!refusal.none())
        line_.put_flash(FLASH_TEXT(" - "))
            .put_flash(text.cause)
            .put_flash(FLASH_TEXT("; "))
            .put_flash(text.cure);
    line_.finish();
    send();
}

// Output never waits: what does not fit is dropped, and counted.
bool Controller::send() {
    if (hardware_.room() < line_.length()) {
        count(counters_.dropped);
        return false;
    }
    hardware_.transmit(line_.data(), line_.length());
    return true;
}

}  // namespace firmware
