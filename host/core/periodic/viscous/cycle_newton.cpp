// Residuals, matrices and steps of Newton's method of cycle_newton.hpp.
#include "periodic/viscous/cycle_newton.hpp"

namespace serpenoid {

namespace {

// The matrix half a cycle later is its mirror image: entries that couple x with y or w change sign.
PackMat mirrored(PackMat a) {
    for (const int i : {1, 2, 3, 6}) a[i] = -a[i];
    return a;
}

PackVec mirrored(const PackVec& a) { return {a[0], -a[1], -a[2]}; }

}  // namespace

std::vector<CycleNode> cycle_nodes(const Robot& robot, const Ground& ground, const GaitTable& gait,
                                   const SpectralMesh& mesh) {
    std::vector<CycleNode> nodes(mesh.nodes);
    for (int k = 0; k < mesh.nodes; ++k) {
        CycleNode& node = nodes[k];
        const double tau = k * mesh.step;
        node.shape.set(robot, gait, all(std::sin(tau)), all(std::cos(tau)), true);
        node.drag = {node.shape, ground};
        const Pack inverse_mass = all(1 / (robot.n * robot.m)), inverse_J = 1.0 / node.shape.J;
        const Pack* D = node.drag.D;
        for (int i = 0; i < 5; ++i) node.field[i] = D[i] * inverse_mass;
        node.field[5] = D[2] * inverse_J;
        node.field[6] = D[4] * inverse_J;
        node.field[7] = D[5] * inverse_J;
        node.field[8] = node.shape.J1 * inverse_J;
    }
    for (int k = 0; k < mesh.nodes; ++k)
        for (int j = 0; j < mesh.nodes; ++j)
            for (int i = 0; i < CycleNode::kFields; ++i)
                nodes[k].slope[i] += mesh.row(k, j).slope[CycleNode::kOdd[i]] * nodes[j].field[i];
    return nodes;
}

void CycleNewton::set(const SpectralMesh& mesh, const std::vector<CycleNode>& nodes, Pack inverse) {
    mesh_ = &mesh;
    nodes_ = &nodes;
    g_ = inverse;
    f_.resize(mesh.nodes);
    r_.resize(mesh.nodes);
    cell_residual_.resize(mesh.nodes);
    cell_.resize(mesh.nodes + 1);
}

PackVec CycleNewton::rate(int k) const {
    const CycleNode& node = (*nodes_)[k];
    const PackVec &u = y[k], drag = node.drag.drag(u, 1.0);
    return {u[2] * u[1] - g_ * drag[0] / nm_, -u[2] * u[0] - g_ * drag[1] / nm_,
            -(g_ * drag[2] + node.shape.J1 * u[2] + node.shape.K1) / node.shape.J};
}

Pack CycleNewton::step() {
    const int N = mesh_->nodes;
    for (int k = 0; k < N; ++k) f_[k] = rate(k);
    residuals();
    for (int k = 0; k < N; ++k) linearise(k);
    cell_[N] = {mirrored(cell_[0].plus), mirrored(cell_[0].inverse), mirrored(cell_[0].residual)};
    PackVec d = solve_cycle();
    Pack change_squared{}, size_squared{}, relative{};
    for (int k = 0; k < N; ++k) {
        PackVec& u = y[k];
        const CycleNode& node = (*nodes_)[k];
        const Pack arm_squared = node.shape.J / nm_, spin = node.shape.K / node.shape.J;
        for (int c = 0; c < 3; ++c) u[c] += d[c];
        change_squared += d[0] * d[0] + d[1] * d[1] + arm_squared * d[2] * d[2];
        size_squared += u[0] * u[0] + u[1] * u[1] + arm_squared * (u[2] * u[2] + spin * spin);
        d = multiply(cell_[k].plus, d);
        for (int c = 0; c < 3; ++c) d[c] += cell_[k].residual[c];
    }
    for (int j = 0; j < kPack; ++j)
        relative[j] = change_squared[j] == 0 ? 0 : std::sqrt(change_squared[j] / size_squared[j]);
    return relative;
}

// Set r = f - y' at the nodes, and for each cell the integral of f minus the change of y.
void CycleNewton::residuals() {
    const int N = mesh_->nodes;
    for (int k = 0; k < N; ++k) {
        PackVec slope{}, integral{};
        for (int j = 0; j < N; ++j) {
            const SpectralMesh::Row& row = mesh_->row(k, j);
            for (int c = 0; c < 3; ++c) {
                slope[c] += row.slope[c > 0] * y[j][c];
                integral[c] += row.integral[c > 0] * f_[j][c];
            }
        }
        const PackVec next = k + 1 < N ? y[k + 1] : mirrored(y[0]);
        for (int c = 0; c < 3; ++c) {
            r_[k][c] = f_[k][c] - slope[c];
            cell_residual_[k][c] = integral[c] - (next[c] - y[k][c]);
        }
    }
}

// A = df/dy from fields and motion, or dA/dtau from the derivatives of both.
PackMat CycleNewton::matrix(const Pack* F, const PackVec& u) const {
    return {-g_ * F[0],        u[2] - g_ * F[1], u[1] - g_ * F[2], -u[2] - g_ * F[1], -g_ * F[3],
            -u[0] - g_ * F[4], -g_ * F[5],       -g_ * F[6],       -g_ * F[7] - F[8]};
}

void CycleNewton::linearise(int k) {
    const CycleNode& node = (*nodes_)[k];
    const double h = mesh_->step;
    const PackMat A = matrix(node.field, y[k]), slope = matrix(node.slope, f_[k]),
                  square = multiply(A, A);
    PackMat minus;
    for (int i = 0; i < 9; ++i) {
        const Pack half = h / 2 * A[i];
        const Pack even = h * h / 12 * (square[i] + slope[i]) + (i % 4 ? 0.0 : 1.0);
        cell_[k].plus[i] = even + half;
        minus[i] = even - half;
    }
    cell_[k].inverse = inverse3(minus);
    cell_[k].residual = multiply(A, r_[k]);
}

// The change of the first node, from the maps between all nodes and the symmetry of the cycle.
PackVec CycleNewton::solve_cycle() {
    const double h = mesh_->step;
    PackMat P{};
    P[0] = P[4] = P[8] = all(1);
    PackVec p{};
    for (int k = 0; k < mesh_->nodes; ++k) {
        Cell &cell = cell_[k], &next = cell_[k + 1];
        PackVec right;
        for (int c = 0; c < 3; ++c)
            right[c] = h * h / 12 * (cell.residual[c] - next.residual[c]) + cell_residual_[k][c];
        cell.plus = multiply(next.inverse, cell.plus);
        cell.residual = multiply(next.inverse, right);
        P = multiply(cell.plus, P);
        p = multiply(cell.plus, p);
        for (int c = 0; c < 3; ++c) p[c] += cell.residual[c];
    }
    PackMat C;
    for (int i = 0; i < 9; ++i) {
        transfer[i] = i < 3 ? P[i] : -P[i];
        C[i] = (i % 4 ? 0.0 : i ? -1.0 : 1.0) - P[i];
    }
    return multiply(inverse3(C), p);
}

void CycleNewton::refine() {
    const int N = mesh_->nodes;
    std::vector<PackVec> fine(2 * N);
    for (int k = 0; k < N; ++k) {
        fine[2 * k] = y[k];
        for (int j = 0; j < N; ++j)
            for (int c = 0; c < 3; ++c)
                fine[2 * k + 1][c] += mesh_->row(k, j).middle[c > 0] * y[j][c];
    }
    y.swap(fine);
}

}  // namespace serpenoid
