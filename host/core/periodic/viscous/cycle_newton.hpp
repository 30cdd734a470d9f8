// Newton's method on the nodes of a cycle on viscous ground; see spectral.hpp for the derivation.
//
// A pack holds gaits of one shape at different rates, one in each lane. They share the tables of
// the shape, whose lanes are equal.
#pragma once

#include "body/viscous_drag.hpp"
#include "periodic/viscous/spectral_mesh.hpp"

namespace serpenoid {

using PackVec = std::array<Pack, 3>;
using PackMat = std::array<Pack, 9>;

// The chain at one node.
struct CycleNode {
    BodyShapeOf<Pack> shape;
    ViscousSumsOf<Pack> drag;
    // D_xx/nm, D_xy/nm, D_xw/nm, D_yy/nm, D_yw/nm, D_xw/J, D_yw/J, D_ww/J, J'/J; and their
    // derivatives by the phase.
    static constexpr int kFields = 9;
    static constexpr bool kOdd[kFields] = {false, true, true, false, false, true};
    Pack field[kFields], slope[kFields];
};

// All nodes of a mesh for one shape.
std::vector<CycleNode> cycle_nodes(const Robot& robot, const Ground& ground, const GaitTable& gait,
                                   const SpectralMesh& mesh);

class CycleNewton {
  public:
    explicit CycleNewton(double nm) : nm_(nm) {}

    // Set the mesh, its nodes, and the inverse of the rates, s/rad.
    void set(const SpectralMesh& mesh, const std::vector<CycleNode>& nodes, Pack inverse);

    // Take one step of Newton's method; returns the change of the motion relative to its speeds.
    Pack step();
    // dy/dtau at node k.
    PackVec rate(int k) const;
    // Interpolate the motion to a mesh of twice as many nodes.
    void refine();

    std::vector<PackVec> y;  // v_x, v_y, nu at every node
    PackMat transfer;        // map of a disturbance over half a cycle, and to the mirror image

  private:
    // The matrices of Hermite's rule at a node, and the residual multiplied by A. solve_cycle()
    // replaces them by the affine map of changes from this node to the next.
    struct Cell {
        PackMat plus, inverse;  // plus: then the matrix of the map
        PackVec residual;       // then the constant of the map
    };
    PackMat matrix(const Pack* field, const PackVec& u) const;
    void residuals();
    void linearise(int k);
    PackVec solve_cycle();

    double nm_;
    Pack g_{};  // 1/omega
    const SpectralMesh* mesh_ = nullptr;
    const std::vector<CycleNode>* nodes_ = nullptr;
    std::vector<PackVec> f_, r_, cell_residual_;  // rates; residuals at nodes, and over cells
    std::vector<Cell> cell_;
};

}  // namespace serpenoid
