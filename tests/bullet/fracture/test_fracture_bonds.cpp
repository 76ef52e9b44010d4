// Bonds are the areas that pieces share; impacts break them from the place of the impact outwards; islands partition
// the pieces, and keep momentum.
#include "quickcullide/bullet_fracture.h"
#include "quickcullide/bullet_mesh.h"
#include "quickcullide/bullet_positions.h"

#include "bullet/fracture/fracture_models.h"
#include "support/suite.h"

#include <btBulletDynamicsCommon.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <vector>

namespace
{
// btScalar may be float: positions of pieces are rounded to it.
const double s_bondRounding = sizeof(btScalar) == sizeof(float) ? 2e-6 : 1e-12;
const double s_infinity = std::numeric_limits<double>::infinity();

using Point = std::array<double, 2>;

//  ---- the oracle: areas of overlapping triangles in the plane of a cut ------------------------------------

/// The edge function: positive to the left of the line from a to b.
double Side(const Point& a, const Point& b, const Point& p)
{
    return (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]);
}

/// The area common to two counterclockwise triangles: the hull of corners inside the other one and of crossings of
/// edges.
double CommonArea(const std::array<Point, 3>& a, const std::array<Point, 3>& b)
{
    std::vector<Point> points;
    auto addInside = [&](const std::array<Point, 3>& of, const std::array<Point, 3>& in)
    {
        for (const Point& p : of)
            if (Side(in[0], in[1], p) >= 0 && Side(in[1], in[2], p) >= 0 && Side(in[2], in[0], p) >= 0)
                points.push_back(p);
    };
    addInside(a, b);
    addInside(b, a);
    for (size_t i = 0; i < 3; i++)
        for (size_t k = 0; k < 3; k++)
        {
            const Point &p = a[i], &q = a[(i + 1) % 3], &r = b[k], &s = b[(k + 1) % 3];
            double start = Side(r, s, p), end = Side(r, s, q);
            double lengths = std::hypot(q[0] - p[0], q[1] - p[1]) * std::hypot(s[0] - r[0], s[1] - r[1]);
            if (std::fabs(start - end) < 1e-5 * lengths) // parallel: what rounding makes of it is no crossing
                continue;
            if ((start > 0) == (end > 0) || (Side(p, q, r) > 0) == (Side(p, q, s) > 0))
                continue;
            double t = start / (start - end);
            points.push_back({p[0] + t * (q[0] - p[0]), p[1] + t * (q[1] - p[1])});
        }
    if (points.size() < 3)
        return 0;
    Point center = {0, 0};
    for (const Point& p : points)
        for (size_t axis = 0; axis < 2; axis++)
            center[axis] += p[axis] / double(points.size());
    std::sort(
        points.begin(), points.end(),
        [&](const Point& x, const Point& y)
        { return std::atan2(x[1] - center[1], x[0] - center[0]) < std::atan2(y[1] - center[1], y[0] - center[0]); });
    double area = 0;
    for (size_t i = 0; i < points.size(); i++)
        area += Side(center, points[i], points[(i + 1) % points.size()]) / 2;
    return area;
}

/// The triangles of a piece in the cut between two sites, in two axes of the cut, both counterclockwise as seen from
/// the second site.
std::vector<std::array<Point, 3>> TrianglesInCut(const qcFractureDef& def, const qcPiece& piece, uint32_t from,
                                                 uint32_t to)
{
    btVector3 normal = (def.sites[to] - def.sites[from]).normalized(), u, v;
    btPlaneSpace1(normal, u, v); // normal, u and v are right-handed
    const btVector3 middle = (def.sites[from] + def.sites[to]) / 2;
    std::vector<std::array<Point, 3>> triangles;
    for (size_t i = 3 * size_t(piece.firstCutTriangle); i < piece.indices.size(); i += 3)
    {
        std::array<Point, 3> triangle;
        double distance = 0;
        for (size_t c = 0; c < 3; c++)
        {
            btVector3 at = piece.frame * piece.vertices[piece.indices[i + c]] - middle;
            distance = std::max(distance, std::fabs(double(at.dot(normal))));
            triangle[c] = {double(at.dot(u)), double(at.dot(v))};
        }
        if (distance > 20 * s_bondRounding)
            continue;
        if (Side(triangle[0], triangle[1], triangle[2]) < 0)
            std::swap(triangle[1], triangle[2]);
        triangles.push_back(triangle);
    }
    return triangles;
}

double SharedArea(const qcFractureDef& def, const qcPiece& a, const qcPiece& b)
{
    double area = 0;
    if (a.site == b.site)
        return 0;
    for (const auto& one : TrianglesInCut(def, a, a.site, b.site))
        for (const auto& other : TrianglesInCut(def, b, a.site, b.site))
            area += CommonArea(one, other);
    return area;
}

/// Checks all bonds of a mesh about 2 long, with and without a bond.
void CheckBonds(const qcFractureDef& def, const char* what)
{
    qcFracture fracture = qcFracture_Split(def);
    ck_assert_msg(fracture.status == qc_statusOk, "%s: %s", what, fracture.message.c_str());
    std::map<std::pair<uint32_t, uint32_t>, const qcBond*> bonds;
    for (const qcBond& bond : fracture.bonds)
        ck_assert_msg(bonds.emplace(std::make_pair(bond.pieceA, bond.pieceB), &bond).second, "%s: a bond twice", what);
    double sum = 0, cuts = 0;
    for (uint32_t a = 0; a < fracture.pieces.size(); a++)
    {
        cuts += qcCutAreaOf(fracture.pieces[a]);
        for (uint32_t b = a + 1; b < fracture.pieces.size(); b++)
        {
            double expected = SharedArea(def, fracture.pieces[a], fracture.pieces[b]);
            auto found = bonds.find({a, b});
            double area = found != bonds.end() ? found->second->area : 0;
            ck_assert_msg(std::fabs(area - expected) <= 200 * s_bondRounding, "%s: pieces %u and %u share %g, not %g",
                          what, a, b, expected, area);
            sum += area;
            if (found == bonds.end())
                continue;
            const qcBond& bond = *found->second;
            btVector3 across = def.sites[fracture.pieces[b].site] - def.sites[fracture.pieces[a].site];
            ck_assert_double_eq_tol(double(bond.normal.dot(across.normalized())), 1, 1e-4);
            btVector3 middle = (def.sites[fracture.pieces[b].site] + def.sites[fracture.pieces[a].site]) / 2;
            ck_assert_double_le(std::fabs(double((bond.center - middle).dot(bond.normal))), 1e-3);
        }
    }
    ck_assert_msg(std::fabs(2 * sum - cuts) <= 1e-4 * cuts, "%s: bonds of %g, cuts of %g", what, sum, cuts);
}

//  ---- breaking ----------------------------------------------------------------------------------------

/// A cube of length 3 in cells of length 1.
qcFracture RegularCube(qcFractureDef* def)
{
    *def = qcBoxToBreak(1.5, 1.5, 1.5);
    for (int i = 0; i < 27; i++)
        def->sites.push_back(btVector3(btScalar(i % 3 - 1), btScalar(i / 3 % 3 - 1), btScalar(i / 9 - 1)));
    return qcFracture_Split(*def);
}

qcFracture BrokenTorus(uint32_t seed)
{
    qcFractureDef def = qcTorusToBreak(32, 16, 1, 0.4);
    qcScatterInside(&def, 40 + 10 * seed, seed);
    return qcFracture_Split(def);
}

struct Random
{
    uint64_t state;

    double Next()
    {
        state = state * 6364136223846793005u + 1442695040888963407u;
        return double(state >> 11) * 0x1p-53;
    }
};

/// Pieces that are connected with the first one over bonds of an energy.
std::set<uint32_t> Connected(const qcFracture& fracture, const std::vector<double>& energies, uint32_t first)
{
    std::set<uint32_t> reached = {first};
    for (size_t before = 0; before != reached.size();)
    {
        before = reached.size();
        for (size_t i = 0; i < fracture.bonds.size(); i++)
            if (energies[i] > 0 &&
                reached.count(fracture.bonds[i].pieceA) + reached.count(fracture.bonds[i].pieceB) == 1)
                reached.insert({fracture.bonds[i].pieceA, fracture.bonds[i].pieceB});
    }
    return reached;
}

void AddMomentum(const qcPieceMotion& motion, const btVector3& inertia, btVector3* linear, btVector3* angular)
{
    *linear += motion.linearVelocity * motion.mass;
    btMatrix3x3 axes = motion.transform.getBasis();
    btVector3 spin = axes.transpose() * motion.angularVelocity;
    *angular +=
        axes * (spin * inertia * motion.mass) + motion.transform.getOrigin().cross(motion.linearVelocity * motion.mass);
}

/// The mesh of several pieces; triangles where they touch cancel each other in all integrals.
qcMassProperties MassOf(const qcFracture& fracture, const std::vector<uint32_t>& pieces)
{
    std::vector<btVector3> vertices;
    std::vector<uint32_t> indices;
    for (uint32_t index : pieces)
    {
        const qcPiece& piece = fracture.pieces[index];
        for (uint32_t corner : piece.indices)
            indices.push_back(corner + uint32_t(vertices.size()));
        for (const btVector3& vertex : piece.vertices)
            vertices.push_back(piece.frame * vertex);
    }
    return qcMeshShape(vertices.data(), qcBulletPositions, sizeof(btVector3), uint32_t(vertices.size()), indices.data(),
                       uint32_t(indices.size() / 3))
        .getMassProperties();
}
} // namespace

START_TEST(bonds_have_the_areas_that_pieces_share)
{
    for (uint32_t seed = 1; seed <= 5; seed++)
    {
        qcFractureDef box = qcBoxToBreak(1, 0.5, 1), hollow = qcHollowToBreak(), torus = qcTorusToBreak(24, 12, 1, 0.4);
        for (qcFractureDef* def : {&box, &hollow, &torus})
            qcScatterInside(def, 4 + 6 * seed, seed);
        CheckBonds(box, "box");
        CheckBonds(hollow, "hollow");
        CheckBonds(torus, "torus");
    }
}
END_TEST

START_TEST(cells_with_two_pieces_on_both_sides_of_a_cut_have_a_bond_for_each_side_of_the_ring)
{
    qcFractureDef torus = qcTorusToBreak(24, 12, 1, 0.4);
    for (int i = 0; i < 4; i++)
        torus.sites.push_back(btVector3(btScalar(-0.37 + 0.25 * i), 0, 0));
    qcFracture fracture = qcFracture_Split(torus);
    ck_assert_uint_eq(fracture.pieces.size(), 6); // the inner two cells hold two each
    ck_assert_uint_eq(fracture.bonds.size(), 6);
    CheckBonds(torus, "ring");
}
END_TEST

START_TEST(bonds_join_only_pieces_that_touch)
{
    // Bars side by side, each cut once: the cut goes through the diagonals of their sides, where triangles have no
    // area.
    for (bool isTurned : {false, true})
    {
        qcFractureDef bars;
        for (int i = 0; i < 4; i++)
            qcAddToBreak(&bars, qcBoxToBreak(0.5, 1, 0.5), btVector3(btScalar(2 * i), 0, 0));
        bars.sites = {btVector3(3, -1, 0), btVector3(3, 1, 0)};
        const btMatrix3x3 turn(btQuaternion(btVector3(1, 2, 3).normalized(), btScalar(isTurned ? 0.7 : 0)));
        for (std::vector<btVector3>* points : {&bars.vertices, &bars.sites})
            for (btVector3& point : *points)
                point = turn * point;
        const qcFracture fracture = qcFracture_Split(bars);
        ck_assert_uint_eq(fracture.pieces.size(), 8);
        ck_assert_uint_eq(fracture.bonds.size(), 4);
        for (const qcBond& bond : fracture.bonds)
        {
            ck_assert_double_eq_tol(bond.area, 1, 20 * s_bondRounding);
            const btVector3 apart =
                fracture.pieces[bond.pieceA].frame.getOrigin() - fracture.pieces[bond.pieceB].frame.getOrigin();
            ck_assert_double_eq_tol(double(apart.length()), 1, 20 * s_bondRounding);
        }
    }
    for (unsigned seed = 1; seed <= 20; seed++)
    {
        qcFractureDef comb = qcCombToBreak(4);
        qcScatterInside(&comb, 8, seed);
        CheckBonds(comb, "comb");
    }
}
END_TEST

START_TEST(a_cut_in_the_plane_of_a_face_parts_what_stands_on_it)
{
    qcFractureDef comb = qcCombToBreak(3);
    comb.sites = {btVector3(btScalar(2.5), btScalar(0.5), 0), btVector3(btScalar(2.5), btScalar(1.5), 0)};
    const qcFracture fracture = qcFracture_Split(comb);
    ck_assert_uint_eq(fracture.pieces.size(), 4);
    ck_assert_uint_eq(fracture.bonds.size(), 3);
    for (const qcBond& bond : fracture.bonds)
        ck_assert_double_eq_tol(bond.area, 2, 20 * s_bondRounding);
    for (const qcPiece& piece : fracture.pieces)
    {
        ck_assert(qcIsClosed(piece));
        ck_assert_double_eq_tol(piece.volume, piece.site == 0 ? 10 : 4, 20 * s_bondRounding);
        // The bottoms of the notches stay the mesh's surface.
        ck_assert_double_eq_tol(qcCutAreaOf(piece), piece.site == 0 ? 6 : 2, 20 * s_bondRounding);
    }
}
END_TEST

START_TEST(a_regular_cube_has_bonds_of_equal_area)
{
    qcFractureDef def;
    qcFracture fracture = RegularCube(&def);
    ck_assert_uint_eq(fracture.pieces.size(), 27);
    ck_assert_uint_eq(fracture.bonds.size(), 54);
    for (const qcBond& bond : fracture.bonds)
    {
        ck_assert_double_eq_tol(bond.area, 1, 1e-6);
        btVector3 middle =
            (def.sites[fracture.pieces[bond.pieceA].site] + def.sites[fracture.pieces[bond.pieceB].site]) / 2;
        ck_assert_double_le(double(bond.center.distance(middle)), 1e-5);
        ck_assert_uint_lt(bond.pieceA, bond.pieceB);
    }
}
END_TEST

START_TEST(no_broken_bond_leaves_one_island_and_all_broken_leave_all_pieces)
{
    qcFractureDef def;
    qcFracture fracture = RegularCube(&def);
    std::vector<double> energies = qcBondEnergies(fracture, 5);
    std::vector<qcIsland> whole = qcFindIslands(fracture, energies);
    ck_assert_uint_eq(whole.size(), 1);
    ck_assert_double_eq_tol(whole[0].volume, 27, 1e-5);
    ck_assert_double_le(double(whole[0].frame.getOrigin().length()), 1e-5);
    for (int axis = 0; axis < 3; axis++) // of a cube of length 3
        ck_assert_double_eq_tol(double(whole[0].inertia[axis]), 1.5, 1e-4);
    double taken = qcBreakBonds(fracture, {13, btVector3(0, 0, 0), 1e9}, &energies);
    ck_assert_double_eq_tol(taken, 54 * 5, 1e-3);
    std::vector<qcIsland> singles = qcFindIslands(fracture, energies);
    ck_assert_uint_eq(singles.size(), 27);
    for (uint32_t i = 0; i < 27; i++)
    {
        ck_assert_uint_eq(singles[i].pieces.size(), 1);
        ck_assert_uint_eq(singles[i].pieces[0], i);
        ck_assert(singles[i].frame == fracture.pieces[i].frame);
        ck_assert_double_eq(singles[i].volume, fracture.pieces[i].volume);
    }
}
END_TEST

START_TEST(islands_partition_the_pieces_as_a_search_does)
{
    for (uint32_t seed = 1; seed <= 8; seed++)
    {
        qcFracture fracture = BrokenTorus(seed);
        std::vector<double> energies = qcBondEnergies(fracture, 1);
        Random random{seed};
        for (double& energy : energies)
            energy = random.Next() < 0.65 ? 0 : energy;
        std::vector<qcIsland> islands = qcFindIslands(fracture, energies);
        std::set<uint32_t> seen;
        for (const qcIsland& island : islands)
        {
            ck_assert(std::is_sorted(island.pieces.begin(), island.pieces.end()));
            ck_assert(Connected(fracture, energies, island.pieces[0]) ==
                      std::set<uint32_t>(island.pieces.begin(), island.pieces.end()));
            for (uint32_t piece : island.pieces)
                ck_assert(seen.insert(piece).second);
        }
        ck_assert_uint_eq(seen.size(), fracture.pieces.size());
        ck_assert_uint_gt(islands.size(), 3);
    }
}
END_TEST

START_TEST(islands_have_the_mass_properties_of_their_pieces_together)
{
    for (uint32_t seed = 1; seed <= 6; seed++)
    {
        qcFracture fracture = BrokenTorus(seed);
        std::vector<double> energies = qcBondEnergies(fracture, 1);
        qcBreakBonds(fracture, {seed, fracture.pieces[seed].frame.getOrigin(), 1.5}, &energies);
        for (const qcIsland& island : qcFindIslands(fracture, energies))
        {
            qcMassProperties expected = MassOf(fracture, island.pieces);
            ck_assert_double_eq_tol(island.volume, expected.volume, 1e-5);
            ck_assert_double_le(double(island.frame.getOrigin().distance(expected.center)), 1e-4);
            btMatrix3x3 axes = island.frame.getBasis(),
                        diagonal(island.inertia.x(), 0, 0, 0, island.inertia.y(), 0, 0, 0, island.inertia.z());
            btMatrix3x3 tensor = axes * diagonal * axes.transpose();
            ck_assert_double_eq_tol(double(axes.determinant()), 1, 1e-4);
            for (int i = 0; i < 3; i++)
                for (int k = 0; k < 3; k++)
                    ck_assert_double_eq_tol(double(tensor[i][k]), double(expected.inertia[i][k]), 2e-4);
        }
    }
}
END_TEST

START_TEST(an_impact_breaks_near_bonds_first_and_takes_their_energy)
{
    for (uint32_t seed = 1; seed <= 6; seed++)
    {
        qcFracture fracture = BrokenTorus(seed);
        const std::vector<double> intact = qcBondEnergies(fracture, 10);
        qcImpact impact;
        impact.piece = seed;
        impact.place = fracture.pieces[seed].frame.getOrigin();
        std::set<size_t> before;
        for (double energy = 0; energy < 60; energy += 4)
        {
            std::vector<double> energies = intact;
            impact.energy = energy;
            double taken = qcBreakBonds(fracture, impact, &energies), sum = 0;
            std::set<size_t> broken;
            size_t weakened = 0;
            for (size_t i = 0; i < energies.size(); i++)
            {
                sum += intact[i] - energies[i];
                weakened += energies[i] > 0 && energies[i] < intact[i];
                if (energies[i] == 0)
                    broken.insert(i);
            }
            ck_assert_double_eq_tol(sum, taken, 1e-9);
            ck_assert_double_eq_tol(taken, energy, 1e-9); // the ring would take more
            ck_assert_uint_le(weakened, 1);
            ck_assert(std::includes(broken.begin(), broken.end(), before.begin(), before.end()));
            // What broke is connected with the piece that was hit: over bonds that broke as well.
            std::vector<double> mask(energies.size(), 0);
            for (size_t i : broken)
                mask[i] = 1;
            std::set<uint32_t> reached = Connected(fracture, mask, impact.piece);
            for (size_t i : broken)
                ck_assert(reached.count(fracture.bonds[i].pieceA) == 1);
            before = broken;
        }
        ck_assert_uint_gt(before.size(), 5);
    }
}
END_TEST

START_TEST(bonds_beyond_the_reach_of_infinite_energy_or_behind_those_hold)
{
    qcFractureDef def;
    qcFracture fracture = RegularCube(&def);
    std::vector<double> energies = qcBondEnergies(fracture, 1);
    qcImpact impact = {13, btVector3(0, 0, 0), 1e9, btScalar(0.6)};
    ck_assert_double_eq_tol(qcBreakBonds(fracture, impact, &energies), 6, 1e-4); // the six of the inner cube
    ck_assert_uint_eq(qcFindIslands(fracture, energies).size(), 2);
    for (double energy : {1e30, s_infinity})
    {
        std::vector<double> fresh = qcBondEnergies(fracture, 1);
        impact.energy = energy;
        ck_assert_double_eq_tol(qcBreakBonds(fracture, impact, &fresh), 6, 1e-4);
        ck_assert(fresh == energies);
    }
    // A wall that never breaks protects what is behind it.
    energies = qcBondEnergies(fracture, 1);
    for (size_t i = 0; i < fracture.bonds.size(); i++)
        if (std::fabs(double(fracture.bonds[i].center.x()) - 0.5) < 1e-3)
            energies[i] = s_infinity;
    uint32_t corner = 0;
    while (def.sites[fracture.pieces[corner].site] != btVector3(-1, -1, -1))
        corner++;
    impact = {corner, btVector3(-1, -1, -1), 1e9};
    ck_assert_double_eq_tol(qcBreakBonds(fracture, impact, &energies), 12 + 12 + 9, 1e-3);
    for (size_t i = 0; i < fracture.bonds.size(); i++)
        ck_assert((energies[i] > 0) == (double(fracture.bonds[i].center.x()) > 0.4));
}
END_TEST

START_TEST(a_weakened_bond_breaks_at_the_rest_of_its_energy)
{
    qcFractureDef def = qcBoxToBreak(1, 1, 1);
    def.sites = {btVector3(-0.5, 0, 0), btVector3(0.5, 0, 0)};
    qcFracture fracture = qcFracture_Split(def);
    ck_assert_uint_eq(fracture.bonds.size(), 1);
    std::vector<double> energies = qcBondEnergies(fracture, 10); // an area of 4
    ck_assert_double_eq_tol(qcBreakBonds(fracture, {0, btVector3(-1, 0, 0), 25}, &energies), 25, 1e-9);
    ck_assert_uint_eq(qcFindIslands(fracture, energies).size(), 1);
    ck_assert_double_eq_tol(qcBreakBonds(fracture, {1, btVector3(1, 0, 0), 25}, &energies), 15, 1e-4);
    ck_assert_uint_eq(qcFindIslands(fracture, energies).size(), 2);
    ck_assert_double_eq(qcBreakBonds(fracture, {1, btVector3(1, 0, 0), 25}, &energies), 0);
}
END_TEST

START_TEST(impacts_that_can_not_be_read_break_nothing)
{
    qcFractureDef def = qcBoxToBreak(1, 1, 1);
    def.sites = {btVector3(-0.5, 0, 0), btVector3(0.5, 0, 0)};
    qcFracture fracture = qcFracture_Split(def);
    const std::vector<double> whole = qcBondEnergies(fracture, 10);
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const qcImpact impacts[] = {
        {2, btVector3(0, 0, 0), 1e9}, {0, btVector3(0, 0, 0), nan}, {0, btVector3(0, 0, 0), -1}};
    std::vector<double> energies = whole, none;
    for (const qcImpact& impact : impacts)
        ck_assert(qcBreakBonds(fracture, impact, &energies) == 0 && energies == whole);
    ck_assert(qcBreakBonds(fracture, {0, btVector3(0, 0, 0), 1e9}, &none) == 0 && none.empty());
    ck_assert(qcBreakBonds(fracture, {0, btVector3(0, 0, 0), 1e9}, nullptr) == 0);
    ck_assert_uint_eq(qcFindIslands(fracture, whole).size(), 1);
    ck_assert_uint_eq(qcFindIslands(fracture, none).size(), 2);
}
END_TEST

START_TEST(islands_keep_momentum_when_they_break_off_and_break_again)
{
    for (uint32_t seed = 1; seed <= 4; seed++)
    {
        const double density = 3;
        qcFracture fracture = BrokenTorus(seed);
        std::vector<double> energies = qcBondEnergies(fracture, 1);
        qcIsland whole = qcFindIslands(fracture, energies)[0];
        btRigidBody::btRigidBodyConstructionInfo info(btScalar(whole.volume * density), nullptr, nullptr,
                                                      whole.inertia * btScalar(whole.volume * density));
        info.m_startWorldTransform =
            btTransform(btQuaternion(btScalar(0.3), btScalar(0.7), btScalar(seed)), btVector3(1, 2, 3));
        btRigidBody body(info);
        body.setLinearVelocity(btVector3(3, -1, 2));
        body.setAngularVelocity(btVector3(1, 2, btScalar(-0.5)));
        btVector3 linear(0, 0, 0), angular(0, 0, 0), sumLinear(0, 0, 0), sumAngular(0, 0, 0);
        AddMomentum(qcMotionOfIsland(body, whole.frame, whole, density), whole.inertia, &linear, &angular);
        qcBreakBonds(fracture, {0, fracture.pieces[0].frame.getOrigin(), 3}, &energies);
        std::vector<qcIsland> islands = qcFindIslands(fracture, energies);
        ck_assert_uint_gt(islands.size(), 1);
        for (const qcIsland& island : islands)
            AddMomentum(qcMotionOfIsland(body, whole.frame, island, density), island.inertia, &sumLinear, &sumAngular);
        ck_assert_double_le(double(sumLinear.distance(linear)), 1e-4 * double(linear.length()));
        ck_assert_double_le(double(sumAngular.distance(angular)), 2e-4 * double(angular.length()));
    }
}
END_TEST

QC_RUN_TESTS("fracture bonds", bonds_have_the_areas_that_pieces_share,
             cells_with_two_pieces_on_both_sides_of_a_cut_have_a_bond_for_each_side_of_the_ring,
             bonds_join_only_pieces_that_touch, a_cut_in_the_plane_of_a_face_parts_what_stands_on_it,
             a_regular_cube_has_bonds_of_equal_area, no_broken_bond_leaves_one_island_and_all_broken_leave_all_pieces,
             islands_partition_the_pieces_as_a_search_does, islands_have_the_mass_properties_of_their_pieces_together,
             an_impact_breaks_near_bonds_first_and_takes_their_energy,
             bonds_beyond_the_reach_of_infinite_energy_or_behind_those_hold,
             a_weakened_bond_breaks_at_the_rest_of_its_energy, impacts_that_can_not_be_read_break_nothing,
             islands_keep_momentum_when_they_break_off_and_break_again)
