// Newton's steps on the nodes of a cycle on viscous ground; spectral.hpp has the derivation.
//
// A pack holds gaits of one shape at different rates, one a lane. They share the tables of the
// shape, whose lanes are alike.
#pragma once

#include "body/viscous_drag.hpp"
#include "periodic/viscous/spectral_mesh.hpp"

namespace serpenoid {

using PackVec = std::array<Pack, 3>;
using PackMat = std::array<Pack, 9>;

// The chain at a node of phase.
struct CycleNode {
    BodyShapeOf<Pack> shape;
    ViscousSumsOf<Pack> drag;
    // D_xx/nm, D_xy/nm, D_xw/nm, D_yy/nm, D_yw/nm, D_xw/J, D_yw/J, D_ww/J, J'/J; and their
    // derivatives by the phase
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

    // The mesh and the rates: their inverse, s/rad.
    void set(const SpectralMesh& mesh, const std::vector<CycleNode>& nodes, Pack inverse);

    // Change the motion; by how much, over the speeds.
    Pack step();
    // Rates by phase at a node.
    PackVec rate(int k) const;
    // The motion on a mesh of twice as many nodes.
    void refine();

    std::vector<PackVec> y;  // v_x, v_y, nu at every node
    PackMat transfer;        // of a disturbance over half a cycle and back into the mirror image

  private:
    // The matrices of Hermite's rule at a node, and their part of the residual there.
    struct Cell {
        PackMat plus, inverse;  // then: from here to the next node
        PackVec part;           // then: what comes there without a change here
    };
    PackMat matrix(const Pack* field, const PackVec& u) const;
    void residuals();
    void linearise(int k);
    PackVec chain();

    double nm_;
    Pack g_{};  // 1/omega
    const SpectralMesh* mesh_ = nullptr;
    const std::vector<CycleNode>* nodes_ = nullptr;
    std::vector<PackVec> f_, r_, miss_;  // rates; residuals at nodes, and over the cells after them
    std::vector<Cell> cell_;
};

}  // namespace serpenoid
