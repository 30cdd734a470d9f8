// One evaluation of either formulation, on plain ground.
#include "run/evaluate.hpp"

#include "model/explicit_model.hpp"

namespace serpenoid {

void evaluate(const RunRequest& q, const double* joint_acceleration, Chain& chain, Joints& joints) {
    chain.apply_ground(q.ground, 0, 0);
    const std::vector<char> imposed(q.robot.n - 1, q.drive == Drive::angle);
    std::vector<double> rotor(q.robot.n - 1), scratch(q.robot.n);
    if (q.formulation == Formulation::explicit_) {
        chain.follow(q.robot.l);
        explicit_mixed(q.robot, imposed, rotor, joint_acceleration, chain, joints);
    } else {
        std::vector<Gap> gaps;
        for (int i = 0; i + 1 < q.robot.n; ++i) gaps.push_back(gap(chain, q.robot.l, i));
        spring_forces(q.spring, Damper(q.robot.n, false), gaps, joints);
        implicit_mixed(q.robot, imposed, rotor, joint_acceleration, scratch, chain, joints);
    }
}

}  // namespace serpenoid
