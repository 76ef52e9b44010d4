// Bonds break by energy, and what still holds together are islands. Griffith: The phenomena of rupture and flow in
// solids, 1921: a crack takes energy in proportion to its area.
#include "quickcullide/bullet_fracture.h"

#include "common/double_vector.h"
#include "common/mass_properties.h"
#include "common/union_find.h"

#include <BulletDynamics/Dynamics/btRigidBody.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>

namespace
{
/// A sum over pieces: volume, centre, and the tensor about it, of density 1.
struct Sum
{
    double volume = 0;
    qcDoubleVector center = {0, 0, 0};
    double tensor[3][3] = {};
};

/// Adds a tensor, given about its own centre, about a point that is `arm` away (Steiner).
void AddTensor(const double own[3][3], double volume, const qcDoubleVector& arm, Sum* sum)
{
    double square = qcDotOf(arm, arm);
    for (size_t i = 0; i < 3; i++)
        for (size_t k = 0; k < 3; k++)
            sum->tensor[i][k] += own[i][k] + volume * ((i == k ? square : 0) - arm[i] * arm[k]);
}

Sum SumOf(const qcFracture& fracture, const std::vector<uint32_t>& pieces)
{
    Sum sum;
    for (uint32_t index : pieces)
    {
        const qcPiece& piece = fracture.pieces[index];
        sum.volume += piece.volume;
        for (size_t axis = 0; axis < 3; axis++)
            sum.center[axis] += piece.volume * double(piece.frame.getOrigin()[int(axis)]);
    }
    for (double& coordinate : sum.center)
        coordinate /= sum.volume;
    for (uint32_t index : pieces)
    {
        const qcPiece& piece = fracture.pieces[index];
        const btMatrix3x3& axes = piece.frame.getBasis();
        double own[3][3] = {};
        for (int i = 0; i < 3; i++)
            for (int k = 0; k < 3; k++)
                for (int axis = 0; axis < 3; axis++)
                    own[i][k] +=
                        piece.volume * double(piece.inertia[axis]) * double(axes[i][axis]) * double(axes[k][axis]);
        AddTensor(own, piece.volume, qcMinus(qcDoubleVectorOf(piece.frame.getOrigin()), sum.center), &sum);
    }
    return sum;
}

/// Fills what follows from the island's pieces.
void Measure(const qcFracture& fracture, qcIsland* island)
{
    if (island->pieces.size() == 1)
    {
        const qcPiece& piece = fracture.pieces[island->pieces[0]];
        island->frame = piece.frame;
        island->volume = piece.volume;
        island->inertia = piece.inertia;
        return;
    }
    Sum sum = SumOf(fracture, island->pieces);
    island->volume = sum.volume;
    double axes[3][3];
    qcDiagonalize(sum.tensor, axes);
    for (int i = 0; i < 3; i++)
    {
        island->frame.getBasis()[i].setValue(btScalar(axes[i][0]), btScalar(axes[i][1]), btScalar(axes[i][2]));
        island->inertia[i] = qcMomentOf(sum.tensor[i][i] / sum.volume);
    }
    island->frame.setOrigin(btVector3(btScalar(sum.center[0]), btScalar(sum.center[1]), btScalar(sum.center[2])));
}
} // namespace

std::vector<double> qcBondEnergies(const qcFracture& fracture, double toughness)
{
    std::vector<double> energies;
    for (const qcBond& bond : fracture.bonds)
        energies.push_back(bond.area * toughness);
    return energies;
}

double qcBreakBonds(const qcFracture& fracture, const qcImpact& impact, std::vector<double>* energies)
{
    if (impact.piece >= fracture.pieces.size() || energies == nullptr || energies->size() != fracture.bonds.size() ||
        !(impact.energy > 0))
        return 0;
    std::vector<std::vector<uint32_t>> bondsOf(fracture.pieces.size());
    for (uint32_t bond = 0; bond < fracture.bonds.size(); bond++)
        for (uint32_t piece : {fracture.bonds[bond].pieceA, fracture.bonds[bond].pieceB})
            bondsOf[piece].push_back(bond);
    using Candidate = std::pair<btScalar, uint32_t>; // distance, bond
    std::priority_queue<Candidate, std::vector<Candidate>, std::greater<Candidate>> nearest;
    std::vector<bool> seen(fracture.bonds.size());
    auto reachPiece = [&](uint32_t piece)
    {
        for (uint32_t bond : bondsOf[piece])
        {
            btScalar distance = fracture.bonds[bond].center.distance(impact.place);
            if (!seen[bond] && (*energies)[bond] > 0 && distance <= impact.reach)
                nearest.push({distance, bond});
            seen[bond] = true;
        }
    };
    double left = impact.energy, sum = 0;
    for (reachPiece(impact.piece); left > 0 && !nearest.empty();)
    {
        uint32_t bond = nearest.top().second;
        nearest.pop();
        double& energy = (*energies)[bond];
        if (energy == std::numeric_limits<double>::infinity())
            continue;
        double taken = std::min(left, energy);
        left -= taken;
        energy -= taken;
        sum += taken;
        if (energy > 0)
            break;
        reachPiece(fracture.bonds[bond].pieceA);
        reachPiece(fracture.bonds[bond].pieceB);
    }
    return sum;
}

std::vector<qcIsland> qcFindIslands(const qcFracture& fracture, const std::vector<double>& energies)
{
    qcUnionFind sets;
    sets.Reset(fracture.pieces.size());
    for (size_t bond = 0; bond < fracture.bonds.size(); bond++)
        if (bond < energies.size() && energies[bond] > 0)
            sets.Unite(fracture.bonds[bond].pieceA, fracture.bonds[bond].pieceB);
    std::vector<qcIsland> islands;
    std::vector<size_t> islandOf(fracture.pieces.size());
    for (uint32_t piece = 0; piece < fracture.pieces.size(); piece++)
    {
        uint32_t first = sets.Find(piece);
        if (first == piece)
        {
            islandOf[piece] = islands.size();
            islands.emplace_back();
        }
        islands[islandOf[first]].pieces.push_back(piece);
    }
    for (qcIsland& island : islands)
        Measure(fracture, &island);
    return islands;
}

qcPieceMotion qcMotionOfIsland(const btRigidBody& body, const btTransform& frame, const qcIsland& island,
                               double density)
{
    qcPieceMotion motion;
    motion.mass = std::max(btScalar(island.volume * density), std::numeric_limits<btScalar>::min());
    motion.transform = body.getWorldTransform() * frame.inverse() * island.frame;
    btVector3 arm = motion.transform.getOrigin() - body.getWorldTransform().getOrigin();
    motion.linearVelocity = body.getLinearVelocity() + body.getAngularVelocity().cross(arm);
    motion.angularVelocity = body.getAngularVelocity();
    return motion;
}
