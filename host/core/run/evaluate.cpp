// One evaluation of either formulation, on plain ground.
#include "run/evaluate.hpp"

#include "model/explicit_model.hpp"

namespace serpenoid {

void evaluate(const RunRequest& request, const double* joint_acceleration, Chain& chain,
              Joints& joints) {
    chain.apply_ground(request.ground, 0, 0);
    const std::vector<char> imposed(request.robot.n - 1, request.drive == Drive::angle);
    std::vector<double> rotor(request.robot.n - 1), scratch(request.robot.n);
    if (request.formulation == Formulation::explicit_) {
        chain.follow(request.robot.l);
        explicit_mixed(request.robot, imposed, rotor, joint_acceleration, chain, joints);
    } else {
        std::vector<Gap> gaps;
        for (int i = 0; i + 1 < request.robot.n; ++i)
            gaps.push_back(gap(chain, request.robot.l, i));
        spring_forces(request.spring, Damper(request.robot.n, false), gaps, joints);
        implicit_mixed(request.robot, imposed, rotor, joint_acceleration, scratch, chain, joints);
    }
}

}  // namespace serpenoid
