// What a scene moves, as a system of first order y' = rate(t, y); methods see no more than this.
//
// It consists of mechanics and two optional parts: contacts that stick and slip, and the energy
// ledger. The state is that of the mechanics, followed by the ledger's integrals.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "scene/energy_ledger.hpp"
#include "scene/mechanics.hpp"
#include "scene/sticking.hpp"

namespace serpenoid {

class System {
  public:
    explicit System(const RunRequest& request);

    int coordinates() const { return mechanics_->coordinates; }
    int lengths() const { return mechanics_->lengths; }  // number of the coordinates in metres
    int dim() const { return 2 * coordinates() + (ledger_ ? EnergyLedger::kIntegrals : 0); }

    void write_state(const Chain& source, double* y) const;
    void fill_chain(double t, const double* y) { mechanics_->fill_chain(t, y); }

    // dy/dt alone, at the least cost.
    void rate(double t, const double* y, double* dy) {
        if (!sticking_ && !ledger_) return mechanics_->rate(t, y, dy);
        rate_with_parts(t, y, dy);
    }
    // Fill the chain with accelerations and ground forces, and the joints, for a record.
    void forces(double t, const double* y);

    // The time of the next jump after t of a drive by setpoints or a table; handle_jump is called
    // at that time. The motion between two jumps is smooth.
    double next_jump(double t) const { return mechanics_->next_jump(t); }
    void handle_jump(double t, const double* y) { mechanics_->handle_jump(t, y); }
    void latch() { mechanics_->latch(); }
    std::unique_ptr<StepEquations> step_equations() { return mechanics_->step_equations(); }

    Sticking* sticking() { return sticking_.get(); }
    EnergyLedger* ledger() { return ledger_ ? &*ledger_ : nullptr; }
    Chain& chain() { return mechanics_->chain; }
    Joints& joints() { return mechanics_->joints; }

    // P_i = -T_i phi_i' of every joint, W.
    void powers(double t, const double* y, std::vector<double>& power);
    // Write one row of the ledger; requires a chain filled from y.
    void ledger_row(const double* y, double* row) const {
        ledger_->row(*mechanics_, y + 2 * coordinates(), row);
    }

  private:
    void rate_with_parts(double t, const double* y, double* dy);

    std::unique_ptr<Mechanics> mechanics_;
    std::unique_ptr<Sticking> sticking_;
    std::optional<EnergyLedger> ledger_;
};

// What counts as 1 in each entry of a state, for error norms: a body length (m) or a radian, and
// these times the unit of the motion's rates. The ledger's entries choose no steps, or the motion
// would depend on what is recorded.
std::vector<double> error_scale(const System& system, const RunRequest& request);

}  // namespace serpenoid
