// Meshes of unit cubes, cut in planes of their faces: cuts are what two cubes share, and surfaces stay surfaces. Meshes
// of random cubes touch themselves in edges and corners.
#include "quickcullide/bullet_fracture.h"

#include "bullet/fracture/fracture_models.h"
#include "support/suite.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <random>
#include <set>
#include <vector>

namespace
{
constexpr int s_side = 3;
// Positions of pieces may be of single precision.
constexpr double s_latticeRounding = 1e-5;

using Cell = std::array<int, 3>;

std::set<Cell> RandomCells(std::mt19937_64* random)
{
    std::set<Cell> cells;
    const int share = int((*random)() % 3) + 1; // of four
    for (int i = 0; i < s_side * s_side * s_side; i++)
        if (int((*random)() % 4) < share)
            cells.insert({i % s_side, i / s_side % s_side, i / (s_side * s_side)});
    return cells;
}

Cell NeighbourOf(const Cell& cell, int axis, int step)
{
    Cell neighbour = cell;
    neighbour[size_t(axis)] += step;
    return neighbour;
}

/// The surface of cubes from each cell's lowest corner on. Cubes share vertices.
qcFractureDef CubesToBreak(const std::set<Cell>& cells)
{
    qcFractureDef def;
    std::map<Cell, uint32_t> vertices;
    auto vertexAt = [&](const Cell& at)
    {
        auto found = vertices.emplace(at, uint32_t(def.vertices.size()));
        if (found.second)
            def.vertices.push_back(btVector3(btScalar(at[0]), btScalar(at[1]), btScalar(at[2])));
        return found.first->second;
    };
    for (const Cell& cell : cells)
        for (int axis = 0; axis < 3; axis++)
            for (int side = 0; side < 2; side++)
            {
                if (cells.count(NeighbourOf(cell, axis, 2 * side - 1)) != 0)
                    continue;
                uint32_t corners[4];
                for (int i = 0; i < 4; i++)
                {
                    Cell at = cell;
                    at[size_t(axis)] += side;
                    at[size_t(axis + 1) % 3] += i == 1 || i == 2;
                    at[size_t(axis + 2) % 3] += i >= 2;
                    corners[i] = vertexAt(at);
                }
                if (side == 0)
                    std::swap(corners[1], corners[3]);
                qcAddQuad(&def, corners[0], corners[1], corners[2], corners[3]);
            }
    return def;
}

btVector3 CentreOf(const Cell& cell)
{
    return btVector3(btScalar(cell[0] + 0.5), btScalar(cell[1] + 0.5), btScalar(cell[2] + 0.5));
}

/// Checks that triangles of one source lie side by side.
void CheckFlat(const qcPiece& piece, int mesh)
{
    struct Sum
    {
        double area = 0;
        btVector3 vector{0, 0, 0};
    };
    std::map<std::pair<bool, uint32_t>, Sum> sums; // by whether it is a cut, and source
    for (uint32_t i = 0; i < piece.sources.size(); i++)
    {
        const btVector3 &a = piece.vertices[piece.indices[3 * i]], &b = piece.vertices[piece.indices[3 * i + 1]],
                        &c = piece.vertices[piece.indices[3 * i + 2]];
        const btVector3 area = (b - a).cross(c - a) / 2;
        Sum& sum = sums[{i >= piece.firstCutTriangle, piece.sources[i]}];
        sum.area += double(area.length());
        sum.vector += area;
    }
    for (const auto& entry : sums)
        ck_assert_msg(entry.second.area - double(entry.second.vector.length()) < s_latticeRounding,
                      "mesh %d: the %s of %u is folded: area %g, vector area %g", mesh,
                      entry.first.first ? "cut" : "surface", entry.first.second, entry.second.area,
                      double(entry.second.vector.length()));
}
} // namespace

START_TEST(sites_in_all_centres_give_the_cubes_and_a_bond_for_each_shared_side)
{
    std::mt19937_64 random(1);
    for (int mesh = 0; mesh < 60; mesh++)
    {
        const std::set<Cell> cells = RandomCells(&random);
        qcFractureDef def = CubesToBreak(cells);
        if (cells.empty())
            continue;
        std::vector<Cell> sites(cells.begin(), cells.end());
        for (const Cell& site : sites)
            def.sites.push_back(CentreOf(site));
        const qcFracture fracture = qcFracture_Split(def);
        ck_assert_msg(fracture.status == qc_statusOk, "%s", fracture.message.c_str());
        ck_assert_uint_eq(fracture.pieces.size(), cells.size());
        size_t shared = 0;
        for (const qcPiece& piece : fracture.pieces)
        {
            const Cell& cell = sites[piece.site];
            size_t neighbours = 0;
            for (int axis = 0; axis < 3; axis++)
                neighbours += cells.count(NeighbourOf(cell, axis, -1)) + cells.count(NeighbourOf(cell, axis, 1));
            ck_assert(qcIsClosed(piece));
            ck_assert_double_eq_tol(piece.volume, 1, s_latticeRounding);
            ck_assert_double_le(double(piece.frame.getOrigin().distance(CentreOf(cell))), s_latticeRounding);
            ck_assert_double_eq_tol(qcCutAreaOf(piece), double(neighbours), s_latticeRounding);
            shared += neighbours;
        }
        ck_assert_uint_eq(2 * fracture.bonds.size(), shared);
        for (const qcBond& bond : fracture.bonds)
        {
            const btVector3 a = CentreOf(sites[fracture.pieces[bond.pieceA].site]),
                            b = CentreOf(sites[fracture.pieces[bond.pieceB].site]);
            ck_assert_double_eq_tol(double(a.distance(b)), 1, s_latticeRounding);
            ck_assert_double_eq_tol(bond.area, 1, s_latticeRounding);
            ck_assert_double_le(double(bond.center.distance((a + b) / 2)), s_latticeRounding);
        }
    }
}
END_TEST

/// Turns and scales the cubes and a site in each cell, empty ones included, moves them by a place, rounds them to
/// single precision or btScalar, and checks that they fall apart into the cubes.
static void CheckFallApart(const std::set<Cell>& cells, const btMatrix3x3& turn, double scale, double place,
                           bool isSingle)
{
    const double side[3] = {0.8 * place, -0.5 * place, 0.33 * place};
    const double rounding = s_latticeRounding + 16 * double(std::numeric_limits<btScalar>::epsilon()) * place;
    qcFractureDef def = CubesToBreak(cells);
    for (int i = 0; i < s_side * s_side * s_side; i++)
        def.sites.push_back(CentreOf({i % s_side, i / s_side % s_side, i / (s_side * s_side)}));
    for (std::vector<btVector3>* points : {&def.vertices, &def.sites})
        for (btVector3& point : *points)
        {
            const btVector3 turned = turn * point;
            for (int axis = 0; axis < 3; axis++)
            {
                const double moved = scale * (double(turned[axis]) + side[axis]);
                point[axis] = isSingle ? btScalar(float(moved)) : btScalar(moved);
            }
        }
    const qcFracture fracture = qcFracture_Split(def);
    ck_assert_msg(fracture.status == qc_statusOk, "%s", fracture.message.c_str());
    ck_assert_uint_eq(fracture.pieces.size(), cells.size());
    const double area = scale * scale, cube = scale * area;
    double volume = 0, bonds = 0;
    size_t shared = 0;
    for (const qcPiece& piece : fracture.pieces)
    {
        const int site = int(piece.site);
        const Cell cell = {site % s_side, site / s_side % s_side, site / (s_side * s_side)};
        size_t neighbours = 0;
        for (int axis = 0; axis < 3; axis++)
            neighbours += cells.count(NeighbourOf(cell, axis, -1)) + cells.count(NeighbourOf(cell, axis, 1));
        ck_assert(qcIsClosed(piece));
        ck_assert_double_eq_tol(piece.volume / cube, 1, rounding);
        ck_assert_double_eq_tol(qcVolumeOf(piece.vertices, piece.indices) / cube, piece.volume / cube, rounding);
        ck_assert_double_eq_tol(qcCutAreaOf(piece) / area, double(neighbours), rounding);
        volume += piece.volume;
        shared += neighbours;
    }
    // None between cubes that touch along an edge.
    ck_assert_uint_eq(2 * fracture.bonds.size(), shared);
    for (const qcBond& bond : fracture.bonds)
        bonds += bond.area / area;
    ck_assert_double_eq_tol(2 * bonds, double(shared), rounding * (1 + double(shared)));
    ck_assert_double_eq_tol(volume + fracture.lostVolume, fracture.volume,
                            (3e-12 + rounding * rounding) * fracture.volume);
}

START_TEST(cubes_that_are_turned_fall_apart_where_sites_are_in_empty_cells_too)
{
    // Their corners are off the planes of the cuts by the rounding of single precision, which files have.
    std::mt19937_64 random(5);
    for (int mesh = 0; mesh < 60; mesh++)
    {
        const std::set<Cell> cells = RandomCells(&random);
        const btMatrix3x3 turn(btQuaternion(btVector3(1, btScalar(mesh % 7), 2).normalized(), btScalar(mesh)));
        if (!cells.empty())
            CheckFallApart(cells, turn, 1, 0, true);
    }
}
END_TEST

START_TEST(cubes_far_from_the_origin_fall_apart_as_those_at_it_do)
{
    for (const double lengths : {3.0, 10.0, 20.0, 30.0, 100.0, 1000.0})
    {
        std::mt19937_64 random(5);
        for (int mesh = 0; mesh < 60; mesh++)
        {
            const std::set<Cell> cells = RandomCells(&random);
            const btMatrix3x3 turn(btQuaternion(btVector3(1, btScalar(mesh % 7), 2).normalized(), btScalar(mesh)));
            if (!cells.empty())
                CheckFallApart(cells, turn, 1, s_side * lengths, lengths < 5);
        }
    }
}
END_TEST

START_TEST(bonds_of_cubes_whose_sides_are_off_the_cuts_by_rounding_are_whole)
{
    std::mt19937_64 random(7);
    for (int mesh = 0; mesh < 600; mesh++)
    {
        const std::set<Cell> cells = RandomCells(&random);
        if (!cells.empty())
            CheckFallApart(cells, btMatrix3x3::getIdentity(), 1 + double(random() % 1000) / 1000, 0, true);
    }
}
END_TEST

START_TEST(a_cut_between_two_layers_is_what_cubes_of_both_share)
{
    std::mt19937_64 random(3);
    for (int mesh = 0; mesh < 60; mesh++)
    {
        const std::set<Cell> cells = RandomCells(&random);
        if (cells.empty())
            continue;
        qcFractureDef def = CubesToBreak(cells);
        def.sites = {CentreOf({0, 1, 1}), CentreOf({1, 1, 1})};
        const qcFracture fracture = qcFracture_Split(def);
        ck_assert_msg(fracture.status == qc_statusOk, "%s", fracture.message.c_str());
        double shared = 0, cuts = 0, bonds = 0;
        for (const Cell& cell : cells)
            shared += double(cell[0] == 0 && cells.count(NeighbourOf(cell, 0, 1)) != 0);
        for (const qcPiece& piece : fracture.pieces)
            cuts += qcCutAreaOf(piece);
        for (const qcBond& bond : fracture.bonds)
            bonds += bond.area;
        ck_assert_msg(std::fabs(cuts - 2 * shared) < s_latticeRounding, "mesh %d: cuts of %g, not %g", mesh, cuts,
                      2 * shared);
        ck_assert_double_eq_tol(bonds, shared, s_latticeRounding);
    }
}
END_TEST

START_TEST(cut_faces_lie_flat_where_cuts_meet_corners_and_edges)
{
    std::mt19937_64 random(2);
    int parted = 0;
    for (int mesh = 0; mesh < 600; mesh++)
    {
        const std::set<Cell> cells = RandomCells(&random);
        qcFractureDef def = CubesToBreak(cells);
        std::set<Cell> sites;
        while (sites.size() < 2 + size_t(mesh) % 8)
            sites.insert({int(random() % 7), int(random() % 7), int(random() % 7)});
        for (const Cell& site : sites)
            def.sites.push_back((CentreOf(site) - btVector3(btScalar(0.5), btScalar(0.5), btScalar(0.5))) / 2);
        if (cells.empty())
            continue;
        const qcFracture fracture = qcFracture_Split(def);
        ck_assert_msg(fracture.status == qc_statusOk, "%s", fracture.message.c_str());
        double volume = 0, cuts = 0, bonds = 0;
        for (const qcPiece& piece : fracture.pieces)
        {
            ck_assert(qcIsClosed(piece));
            CheckFlat(piece, mesh);
            volume += piece.volume;
            cuts += qcCutAreaOf(piece);
        }
        for (const qcBond& bond : fracture.bonds)
            bonds += bond.area;
        ck_assert_double_eq_tol(volume, double(cells.size()), s_latticeRounding * double(cells.size()));
        ck_assert_msg(std::fabs(2 * bonds - cuts) < s_latticeRounding * (1 + cuts), "mesh %d: bonds of %g, cuts of %g",
                      mesh, bonds, cuts);
        parted += fracture.bonds.size() > 1;
    }
    ck_assert_int_gt(parted, 300);
}
END_TEST

QC_RUN_TESTS("fracture on a lattice", sites_in_all_centres_give_the_cubes_and_a_bond_for_each_shared_side,
             cubes_that_are_turned_fall_apart_where_sites_are_in_empty_cells_too,
             cubes_far_from_the_origin_fall_apart_as_those_at_it_do,
             bonds_of_cubes_whose_sides_are_off_the_cuts_by_rounding_are_whole,
             a_cut_between_two_layers_is_what_cubes_of_both_share, cut_faces_lie_flat_where_cuts_meet_corners_and_edges)
