// The lines of the host: reading, sessions, sequence numbers, and one verdict for each line.
#include "controller.h"
#include "progmem.h"

namespace firmware {
namespace {

const char kWhyKey[] FLASH = "key";

const uint8_t kBytesPerPass = 64;

// Whether a command may still be obeyed if a stop that was sent after it came first.
bool harmless(Verb verb) {
    return verb == Verb::Hello || verb == Verb::Bye || verb == Verb::Ping || verb == Verb::Stop;
}

}  // namespace

void Controller::receive() {
    for (uint8_t n = 0; n < kBytesPerPass; ++n) {
        obey_stops();
        if (waiting_ != LineReader::kNothing) return;
        const int16_t byte = input_.pop();
        if (byte == Input::kNothing) return;
        if (byte == Input::kStopHere) {
            reader_.clear();
            continue;
        }
        waiting_ = reader_.push(static_cast<uint8_t>(byte));
        if (waiting_ == LineReader::kLine && ends_in_stop(reader_.data(), reader_.length())) {
            waiting_ = LineReader::kNothing;  // the stop was obeyed on arrival
            reader_.clear();
        }
    }
}

// Obey a stop at once, before earlier lines and even if its verdict must wait for room.
void Controller::obey_stops() {
    for (char which; (which = input_.take_stop()) != 0;) {
        uint8_t& due = which == '!' ? key_answers_due_ : word_answers_due_;
        if (due < 255) ++due;
        silent_frames_ = 0;
        count(counters_.good);
        stop(which == '!' ? kWhyKey : kWhyCommand);
    }
}

// Whether an answer fits into the queue, and the next telemetry line still fits after it.
bool Controller::may_answer() {
    const uint16_t room = line_.room();
    if (room < kMaxAnswerBytes) return false;
    if (settings_.value_u[kEvery] == 0) return true;
    const uint16_t excess_bytes =
        static_cast<uint16_t>(max_telemetry_bytes() + kMaxAnswerBytes - room);
    const uint32_t frames_us =
        telemetry_wait_ > 1 ? (telemetry_wait_ - 1) * uint32_t{frame_us()} : 0;
    const uint32_t left_us = spare_us() + frames_us;
    return room >= max_telemetry_bytes() + kMaxAnswerBytes ||
           left_us > excess_bytes * uint32_t{kByteUs};
}

void Controller::answer_stops() {
    if ((key_answers_due_ | word_answers_due_) == 0 || !may_answer()) return;
    if (key_answers_due_ != 0) {
        --key_answers_due_;
        verdict(Tag{Source::StopKey, 0}, Refusal());
    } else if (word_answers_due_ != 0) {
        --word_answers_due_;
        verdict(Tag{Source::Typed, 0}, Refusal());
    }
}

void Controller::accept_waiting() {
    answer_stops();
    if (waiting_ == LineReader::kNothing || report_ != Report::None) return;
    if (!may_answer()) return;
    if (waiting_ == LineReader::kLine) {
        accept_line();
    } else {
        refuse_damaged(waiting_ == LineReader::kOverlong ? Error::Overlong : Error::Garbled);
    }
    reader_.clear();
    waiting_ = LineReader::kNothing;
}

void Controller::accept_line() {
    Envelope envelope;
    const Error damage = check_line(reader_.data(), reader_.length(), envelope);
    if (damage == Error::Crc) return refuse_damaged(damage);
    const bool leaves = is_bare_bye(reader_.data(), reader_.length());
    if (leaves) session_ = false;
    if (session_ && !envelope.has_crc) return refuse_damaged(Error::NoCrc);
    if (damage == Error::Sequence || (session_ && !envelope.has_number)) {
        return refuse_damaged(Error::Sequence);
    }
    accept_body(envelope);
}

void Controller::accept_body(const Envelope& envelope) {
    Command command;
    Refusal refusal = parse_command(envelope.body, envelope.length, command);
    const bool greets = refusal.none() && command.verb == Verb::Hello;
    tag_ = Tag{envelope.has_number ? Source::Numbered : Source::Typed, envelope.number};
    if (session_ && !greets && !in_order(envelope)) return;
    last_number_ = envelope.number;
    if (refusal.none()) {
        const bool too_late = input_.before_stop() && !harmless(command.verb);
        refusal = too_late ? Refusal(Error::Stopped) : obey(command);
    }
    if (greets && refusal.none() && envelope.has_crc && envelope.has_number) session_ = true;
    count(counters_.good);
    if (envelope.has_crc || refusal.none()) silent_frames_ = 0;
    last_error_ = refusal.error;
    if (refusal.none() && report_ != Report::None) return;  // the verdict follows the report
    if (refusal.none() && (command.verb == Verb::Save || command.verb == Verb::Load)) {
        store_tag_ = tag_;  // the verdict follows when the store has finished
        return;
    }
    verdict(tag_, refusal);
}

// Whether a numbered line of a session is to be obeyed; if not, this answers it.
bool Controller::in_order(const Envelope& envelope) {
    const uint16_t number_step = static_cast<uint16_t>(envelope.number - last_number_);
    silent_frames_ = 0;
    if (number_step >= 1 && number_step < 0x8000) {
        count(counters_.lost, static_cast<uint16_t>(number_step - 1));
        return true;
    }
    const bool pending = store_.busy() && store_tag_.number == envelope.number;
    if (number_step == 0 && !pending) verdict(tag_, Refusal(last_error_), true);
    if (number_step != 0) verdict(tag_, Refusal(Error::Sequence));
    return false;
}

void Controller::refuse_damaged(Error error) {
    count(counters_.damaged);
    tag_ = Tag{Source::Damaged, 0};
    verdict(tag_, Refusal(error));
}

void Controller::work_on_store() {
    const bool saved = store_.saving();
    if (!store_.step()) return;
    const Error error = saved             ? store_.good() ? Error::None : Error::Eeprom
                        : store_.loaded() ? Error::None
                                          : Error::Empty;
    if (!saved) configure();
    if (store_tag_.number == last_number_) last_error_ = error;
    verdict(store_tag_, Refusal(error));
}

void Controller::verdict(const Tag& tag, const Refusal& refusal, bool repeated) {
    line_.begin().put_flash(refusal.none() ? FLASH_TEXT("ok: #") : FLASH_TEXT("err: #"));
    if (tag.source == Source::Numbered) {
        line_.put_unsigned(tag.number);
    } else {
        line_.put(static_cast<char>(tag.source));
    }
    const ErrorText text = error_text(refusal.error);
    if (!refusal.none()) line_.put(' ').put_flash(text.word);
    if (repeated) line_.put_flash(FLASH_TEXT(" again"));
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
    send();
}

// Finish a line. Output never waits: a line that does not fit is dropped and counted.
void Controller::send() {
    if (!line_.finish()) count(counters_.dropped);
    telemetry_sent_while_waiting_ = 0;
}

}  // namespace firmware
