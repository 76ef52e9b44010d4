// Pieces of a broken mesh are closed, lie in their cells, fill the mesh and keep its momentum; bad input is refused
// with the place of the defect.
#include "quickcullide/bullet_fracture.h"
#include "quickcullide/bullet_mesh.h"

#include "bullet/fracture/fracture_models.h"
#include "support/suite.h"

#include <btBulletDynamicsCommon.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <ctime>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace
{
// btScalar may be float: positions of pieces are rounded to it.
const double s_rounding = sizeof(btScalar) == sizeof(float) ? 2e-6 : 1e-12;

//  ---- checks ----------------------------------------------------------------------------------------

/// Max distance of a piece's points from its cell.
double Excess(const qcFractureDef& def, const qcPiece& piece)
{
    double max = 0;
    const btVector3& site = def.sites[piece.site];
    for (const btVector3& vertex : piece.vertices)
        for (const btVector3& other : def.sites)
        {
            btVector3 across = other - site, at = piece.frame * vertex - (site + other) / 2;
            double length = double(across.length());
            if (length > 0)
                max = std::max(max, double(at.dot(across)) / length);
        }
    return max;
}

/// The minimum height of a triangle, and the minimum cosine between the normals at an edge.
void MeasureTriangles(const qcPiece& piece, double* height, double* cosine)
{
    std::map<std::pair<uint32_t, uint32_t>, btVector3> normals;
    *height = 1;
    *cosine = 1;
    for (size_t i = 0; i < piece.indices.size(); i += 3)
    {
        const btVector3 &a = piece.vertices[piece.indices[i]], &b = piece.vertices[piece.indices[i + 1]],
                        &c = piece.vertices[piece.indices[i + 2]];
        btVector3 normal = (b - a).cross(c - a);
        double longest = double(std::max({a.distance(b), b.distance(c), c.distance(a)}));
        *height = std::min(*height, double(normal.length()) / longest);
        for (size_t k = 0; k < 3; k++)
            normals[{piece.indices[i + k], piece.indices[i + (k + 1) % 3]}] = normal.normalized();
    }
    for (const auto& edge : normals)
    {
        auto other = normals.find({edge.first.second, edge.first.first});
        if (other != normals.end())
            *cosine = std::min(*cosine, double(edge.second.dot(other->second)));
    }
}

void CheckWhole(const qcFractureDef& def, const qcFracture& fracture, double volume, const char* what)
{
    ck_assert_msg(fracture.status == qc_statusOk, "%s: %s", what, fracture.message.c_str());
    double sum = 0;
    btVector3 first(0, 0, 0);
    for (size_t i = 0; i < fracture.pieces.size(); i++)
    {
        const qcPiece& piece = fracture.pieces[i];
        ck_assert_msg(qcIsClosed(piece), "%s: piece %zu is open", what, i);
        ck_assert_msg(std::fabs(qcVolumeOf(piece.vertices, piece.indices) - double(piece.volume)) <= 40 * s_rounding,
                      "%s: piece %zu is %g, not %g", what, i, qcVolumeOf(piece.vertices, piece.indices),
                      double(piece.volume));
        ck_assert_msg(Excess(def, piece) < 4 * s_rounding, "%s: piece %zu leaves its cell by %g", what, i,
                      Excess(def, piece));
        ck_assert_uint_le(3 * size_t(piece.firstCutTriangle), piece.indices.size());
        sum += double(piece.volume);
        first += piece.frame.getOrigin() * btScalar(piece.volume);
    }
    ck_assert_double_eq_tol(double(fracture.volume), volume, volume * s_rounding);
    ck_assert_double_eq_tol(sum + double(fracture.lostVolume), volume, volume * 4 * s_rounding);
    ck_assert_double_le(double(fracture.lostVolume), volume * 1e-6);
}

void ExpectRefusal(const qcFractureDef& def, const char* part)
{
    qcFracture fracture = qcFracture_Split(def);
    ck_assert_int_eq(fracture.status, qc_statusBadInput);
    ck_assert_uint_eq(fracture.pieces.size(), 0);
    ck_assert_msg(fracture.message.find(part) != std::string::npos, "\"%s\" does not say \"%s\"",
                  fracture.message.c_str(), part);
    ck_assert_str_eq(qcLastMessage(), fracture.message.c_str());
}
} // namespace

START_TEST(pieces_are_closed_lie_in_their_cells_and_fill_the_mesh)
{
    for (uint32_t seed = 1; seed <= 6; seed++)
    {
        uint32_t count = seed * seed * 5;
        qcFractureDef box = qcBoxToBreak(1, 0.5, 2), hollow = qcHollowToBreak(), torus = qcTorusToBreak(32, 16, 1, 0.4);
        for (qcFractureDef* def : {&box, &hollow, &torus})
            qcScatterInside(def, count, seed);
        qcFracture fracture = qcFracture_Split(box);
        CheckWhole(box, fracture, 8, "box");
        ck_assert_uint_eq(fracture.pieces.size(), count); // a convex mesh: one piece for each cell
        CheckWhole(hollow, qcFracture_Split(hollow), 8 - 0.064, "hollow");
        qcFracture ring = qcFracture_Split(torus);
        double exact = 0;
        for (size_t i = 0; i < torus.indices.size(); i += 3)
            exact += double(torus.vertices[torus.indices[i]].dot(
                         torus.vertices[torus.indices[i + 1]].cross(torus.vertices[torus.indices[i + 2]]))) /
                     6;
        CheckWhole(torus, ring, exact, "torus");
    }
}
END_TEST

START_TEST(two_components_in_a_cell_make_two_pieces)
{
    // Slabs across the ring: its two sides are components.
    qcFractureDef torus = qcTorusToBreak(48, 12, 1, 0.25);
    for (int i = -2; i <= 2; i++)
        torus.sites.push_back(btVector3(0, btScalar(0.45 * i), 0));
    qcFracture fracture = qcFracture_Split(torus);
    ck_assert_int_eq(fracture.status, qc_statusOk);
    std::map<uint32_t, int> piecesOf;
    for (const qcPiece& piece : fracture.pieces)
        piecesOf[piece.site]++;
    ck_assert_int_eq(piecesOf[2], 2);
    ck_assert_int_eq(piecesOf[0], 1);
    ck_assert_int_eq(piecesOf[4], 1);
}
END_TEST

START_TEST(cuts_through_vertices_and_along_faces_are_closed)
{
    // Sites in a lattice: bisectors go through corners of the box, along its faces and through each other's edges.
    qcFractureDef box = qcBoxToBreak(1, 1, 1);
    for (int i = 0; i < 27; i++)
        box.sites.push_back(btVector3(btScalar(i % 3 - 1), btScalar(i / 3 % 3 - 1), btScalar(i / 9 - 1)));
    CheckWhole(box, qcFracture_Split(box), 8, "lattice");
    box.sites.clear();
    for (int i = 0; i < 8; i++)
        box.sites.push_back(btVector3(btScalar(i & 1) * 2, btScalar(i & 2), btScalar(i & 4) / 2));
    qcFracture whole = qcFracture_Split(box);
    CheckWhole(box, whole, 8, "faces");
    ck_assert_uint_eq(whole.pieces.size(), 1);
    box.sites = {btVector3(btScalar(0.1), 0, 0)};
    qcFracture one = qcFracture_Split(box);
    CheckWhole(box, one, 8, "one site");
    ck_assert_uint_eq(one.pieces[0].firstCutTriangle, 12);
}
END_TEST

START_TEST(cuts_through_flat_sides_leave_no_flat_or_folded_triangle)
{
    // Each side is of two triangles: where a cut crosses their diagonal, the outline of the new face goes straight on.
    qcFractureDef torus = qcTorusToBreak(32, 16, 1, 0.4), box = qcBoxToBreak(1, 0.5, 2);
    btMatrix3x3 turn(btQuaternion(btVector3(1, 2, 3).normalized(), btScalar(1.1)));
    for (btVector3& vertex : box.vertices)
        vertex = turn * vertex;
    for (qcFractureDef* def : {&torus, &box})
    {
        qcScatterInside(def, 40, 3);
        for (const qcPiece& piece : qcFracture_Split(*def).pieces)
        {
            double height, cosine;
            MeasureTriangles(piece, &height, &cosine);
            ck_assert_msg(height > 1e-5, "a height of %g", height);
            ck_assert_msg(cosine > -0.9999, "a cosine of %g", cosine);
        }
    }
}
END_TEST

START_TEST(triangles_back_to_back_are_dropped)
{
    qcFractureDef box = qcBoxToBreak(1, 1, 1);
    box.vertices.push_back(btVector3(2, 2, 2));
    for (uint32_t index : {1u, 7u, 8u, 7u, 1u, 8u})
        box.indices.push_back(index);
    qcScatterInside(&box, 30, 2);
    qcFracture fracture = qcFracture_Split(box);
    CheckWhole(box, fracture, 8, "a box with a fin");
    for (const qcPiece& piece : fracture.pieces)
        for (const btVector3& vertex : piece.vertices)
            ck_assert_double_le(double((piece.frame * vertex).absolute()[0]), 1 + s_rounding);
}
END_TEST

START_TEST(hollows_make_holes_in_cuts)
{
    qcFractureDef def = qcBoxToBreak(1, 1, 1);
    for (int i = 0; i < 27; i++)
    {
        qcFractureDef hollow = qcBoxToBreak(0.1, 0.1, 0.1, true);
        btVector3 place(btScalar(0.5 * (i % 3 - 1)), btScalar(0.5 * (i / 3 % 3 - 1)), btScalar(0.5 * (i / 9 - 1)));
        for (uint32_t index : hollow.indices)
            def.indices.push_back(index + uint32_t(def.vertices.size()));
        for (const btVector3& vertex : hollow.vertices)
            def.vertices.push_back(vertex + place);
    }
    for (uint32_t count : {3u, 20u, 150u})
    {
        qcScatterInside(&def, count, count);
        CheckWhole(def, qcFracture_Split(def), 8 - 27 * 0.008, "hollows");
    }
}
END_TEST

START_TEST(a_hollow_belongs_to_the_piece_around_it)
{
    const btVector3 nowhere(0, 0, 0);
    // Shells in each other, and a hollow box in the hole of a ring, whose box contains it.
    qcFractureDef shells = qcBoxToBreak(10, 10, 10), ring = qcTorusToBreak(32, 16, 4, 1);
    qcAddToBreak(&shells, qcBoxToBreak(9, 9, 9, true), nowhere);
    qcFractureDef* const models[] = {&shells, &ring};
    const double outer[] = {8000 - 5832, qcVolumeOf(ring.vertices, ring.indices)};
    for (int i = 0; i < 2; i++)
    {
        qcAddToBreak(models[i], qcBoxToBreak(0.9, 0.9, 0.9, true), nowhere);
        qcAddToBreak(models[i], qcBoxToBreak(1, 1, 1), nowhere);
        models[i]->sites = {nowhere};
        const qcFracture fracture = qcFracture_Split(*models[i]);
        ck_assert_uint_eq(fracture.pieces.size(), 2);
        for (const qcPiece& piece : fracture.pieces)
        {
            const double expected = piece.volume > 10 ? outer[i] : 8 - 5.832;
            ck_assert_double_eq_tol(piece.volume, expected, expected * 10 * s_rounding);
            ck_assert_double_eq_tol(qcVolumeOf(piece.vertices, piece.indices), expected, expected * 40 * s_rounding);
        }
    }
}
END_TEST

// A tetrahedron whose first corner, in any order of its corners, is on the surface of a cube, or where cuts meet.
START_TEST(a_hollow_that_touches_the_surface_or_a_cut_is_kept)
{
    const btVector3 corners[][4] = {
        {{1, 1, 0.125}, {0.5, 0.5, 0.25}, {0.5, 0.5, -0.25}, {0.25, 0.75, 0}},
        {{1, 1, 0.25}, {1, 1, -0.25}, {0.5, 0.375, 0}, {0.375, 0.5, 0.25}},
        {{1, 0.25, 0.375}, {0.5, 0.5, 0.25}, {0.5, 0.5, -0.25}, {0.25, 0.75, 0}},
        {{0, 0, 0}, {0.5, 0.375, 0.25}, {0.25, 0.5, 0.375}, {0.25, 0.25, 0.625}},
    };
    for (const auto& hollow : corners)
        for (int order = 0; order < 4; order++)
        {
            qcFractureDef tetrahedron, def = qcBoxToBreak(1, 1, 1);
            for (int i = 0; i < 4; i++)
                tetrahedron.vertices.push_back(hollow[(i + order) % 4]);
            tetrahedron.indices = {0, 2, 1, 0, 3, 2, 0, 1, 3, 1, 2, 3};
            if (qcVolumeOf(tetrahedron.vertices, tetrahedron.indices) > 0)
                for (size_t i = 0; i < tetrahedron.indices.size(); i += 3)
                    std::swap(tetrahedron.indices[i], tetrahedron.indices[i + 1]);
            const double volume = 8 + qcVolumeOf(tetrahedron.vertices, tetrahedron.indices);
            qcAddToBreak(&def, tetrahedron, btVector3(0, 0, 0));
            for (int i = 0; i < 8; i++)
                def.sites.push_back(btVector3(i & 1 ? 0.5 : -0.5, i & 2 ? 0.5 : -0.5, i & 4 ? 0.5 : -0.5));
            for (size_t sites : {8, 1})
            {
                def.sites.resize(sites);
                const qcFracture fracture = qcFracture_Split(def);
                CheckWhole(def, fracture, volume, "touching hollow");
                ck_assert_double_eq(fracture.lostVolume, 0);
            }
        }
}
END_TEST

START_TEST(parts_that_touch_in_an_edge_or_a_corner_only_are_pieces_of_their_own)
{
    // Beside and above each other, on common vertices; the first box once more with a hollow that touches its surface.
    for (const bool hasHollow : {false, true})
        for (const btVector3& by : {btVector3(2, 2, 0), btVector3(2, 2, 2), btVector3(-2, 0, 2)})
        {
            qcFractureDef def = qcBoxToBreak(1, 1, 1);
            qcAddToBreak(&def, qcBoxToBreak(1, 1, 1), by);
            if (hasHollow)
            {
                qcFractureDef hollow;
                hollow.vertices = {btVector3(1, 0.25, 0.375), btVector3(0.5, 0.5, 0.25), btVector3(0.5, 0.5, -0.25),
                                   btVector3(0.25, 0.75, 0)};
                hollow.indices = {0, 2, 1, 0, 3, 2, 0, 1, 3, 1, 2, 3};
                if (qcVolumeOf(hollow.vertices, hollow.indices) > 0)
                    for (size_t i = 0; i < hollow.indices.size(); i += 3)
                        std::swap(hollow.indices[i], hollow.indices[i + 1]);
                qcAddToBreak(&def, hollow, btVector3(0, 0, 0));
            }
            def.sites = {btVector3(0, 0, 0)};
            const double volume = qcVolumeOf(def.vertices, def.indices);
            const qcFracture fracture = qcFracture_Split(def);
            CheckWhole(def, fracture, volume, "touching boxes");
            ck_assert_uint_eq(fracture.pieces.size(), 2);
            ck_assert_double_eq_tol(fracture.pieces[0].volume, volume - 8, 1e-5);
            ck_assert_double_eq_tol(fracture.pieces[1].volume, 8, 1e-5);
            ck_assert_double_eq(fracture.lostVolume, 0);
            ck_assert_uint_eq(fracture.bonds.size(), 0);
        }
}
END_TEST

START_TEST(a_cut_through_many_teeth_takes_linear_time)
{
    double seconds[2];
    for (int i = 0; i < 2; i++)
    {
        const int teeth = i == 0 ? 1000 : 8000;
        qcFractureDef def = qcCombToBreak(teeth);
        def.sites = {btVector3(btScalar(teeth), 0.5, 0), btVector3(btScalar(teeth), 3, 0)};
        seconds[i] = std::numeric_limits<double>::max();
        for (int run = 0; run < 3; run++)
        {
            const std::clock_t start = std::clock();
            ck_assert_uint_eq(qcFracture_Split(def).pieces.size(), size_t(teeth) + 1);
            seconds[i] = std::min(seconds[i], double(std::clock() - start) / CLOCKS_PER_SEC);
        }
    }
    // Eight times as many teeth take 9 times as long. With the tesselator for all teeth at once it was 48.
    ck_assert_msg(seconds[1] < 24 * seconds[0], "%g s, and %g s for eight times as many teeth", seconds[0], seconds[1]);
}
END_TEST

START_TEST(parts_that_touch_each_other_in_edges_are_told_apart_in_linear_time)
{
    double seconds[2];
    for (int i = 0; i < 2; i++)
    {
        const int count = i == 0 ? 1000 : 8000;
        qcFractureDef def;
        for (int box = 0; box < count; box++)
            qcAddToBreak(&def, qcBoxToBreak(1, 1, 1), btVector3(btScalar(2 * box), btScalar(2 * box), 0));
        def.sites = {btVector3(0, 0, 0)};
        seconds[i] = std::numeric_limits<double>::max();
        for (int run = 0; run < 3; run++)
        {
            const std::clock_t start = std::clock();
            ck_assert_uint_eq(qcFracture_Split(def).pieces.size(), size_t(count));
            seconds[i] = std::min(seconds[i], double(std::clock() - start) / CLOCKS_PER_SEC);
        }
    }
    // Eight times as many boxes take 8 times as long. With a list of all vertices for each box it was 100.
    ck_assert_msg(seconds[1] < 24 * seconds[0], "%g s, and %g s for eight times as many boxes", seconds[0], seconds[1]);
}
END_TEST

/// An L of 2 x 2 x 1, and sites whose cuts lie in its inner faces.
qcFractureDef AngleToBreak()
{
    const double outline[6][2] = {{-1, -1}, {1, -1}, {1, 0}, {0, 0}, {0, 1}, {-1, 1}};
    qcFractureDef def;
    for (double z : {-0.5, 0.5})
        for (const auto& corner : outline)
            def.vertices.push_back(btVector3(btScalar(corner[0]), btScalar(corner[1]), btScalar(z)));
    for (uint32_t i = 0; i < 6; i++)
        qcAddQuad(&def, i, (i + 1) % 6, (i + 1) % 6 + 6, i + 6);
    qcAddQuad(&def, 3, 2, 1, 0);
    qcAddQuad(&def, 5, 4, 3, 0);
    qcAddQuad(&def, 6, 7, 8, 9);
    qcAddQuad(&def, 6, 9, 10, 11);
    for (int i = 0; i < 4; i++)
        def.sites.push_back(btVector3(btScalar(i % 2 - 0.5), btScalar(i / 2 - 0.5), 0));
    return def;
}

START_TEST(cuts_in_the_faces_of_a_turned_mesh_leave_its_surface_outside)
{
    for (int turn = 0; turn < 40; turn++)
    {
        qcFractureDef def = AngleToBreak();
        const btMatrix3x3 by(btQuaternion(btVector3(1, btScalar(turn % 7), 2).normalized(), btScalar(turn)));
        for (std::vector<btVector3>* points : {&def.vertices, &def.sites})
            for (btVector3& point : *points)
                point = by * point;
        const qcFracture fracture = qcFracture_Split(def);
        CheckWhole(def, fracture, 3, "angle");
        ck_assert_uint_eq(fracture.pieces.size(), 3);
        double cut = 0;
        for (const qcPiece& piece : fracture.pieces)
            cut += qcCutAreaOf(piece);
        ck_assert_double_eq_tol(cut, 4, 1e-4);
    }
}
END_TEST

START_TEST(sites_around_an_impact_far_from_zero_are_different)
{
    for (double at : {0.0, 1e3, 1e5})
    {
        const btVector3 half(1, 1, 1), impact = btScalar(at) * half;
        std::set<std::array<btScalar, 3>> different;
        for (const btVector3& site : qcScatterSites(impact - half, impact + half, 3000, 5, &impact))
            different.insert({site.x(), site.y(), site.z()});
        ck_assert_uint_eq(different.size(), 3000);
    }
    // All positions of a small box: each once.
    btVector3 lower(1e6, 1e6, 1e6), upper = lower;
    for (int axis = 0; axis < 3; axis++)
        for (int i = 0; i < 8; i++)
            upper[axis] = std::nextafter(upper[axis], 2 * upper[axis]);
    std::set<std::array<btScalar, 3>> all;
    for (const btVector3& site : qcScatterSites(lower, upper, 9 * 9 * 9, 5, &lower))
        all.insert({site.x(), site.y(), site.z()});
    ck_assert_uint_eq(all.size(), 9 * 9 * 9);
    const btVector3 point(1, 2, 3);
    ck_assert_uint_eq(qcScatterSites(point, point, 3, 1, nullptr).size(), 3); // there is no other place
}
END_TEST

START_TEST(the_same_input_gives_the_same_pieces_and_sites_gather_around_an_impact)
{
    qcFractureDef torus = qcTorusToBreak(24, 12, 1, 0.4);
    qcScatterInside(&torus, 40, 7);
    qcFracture a = qcFracture_Split(torus), b = qcFracture_Split(torus);
    ck_assert_uint_eq(a.pieces.size(), b.pieces.size());
    for (size_t i = 0; i < a.pieces.size(); i++)
    {
        ck_assert(a.pieces[i].indices == b.pieces[i].indices);
        ck_assert(a.pieces[i].frame == b.pieces[i].frame);
        ck_assert(a.pieces[i].vertices == b.pieces[i].vertices);
    }
    btVector3 lower(-1, -1, -1), upper(1, 1, 1), impact(1, 0, 0), outside(7, 0, 0);
    ck_assert(qcScatterSites(lower, upper, 1000, 3, &outside) == qcScatterSites(lower, upper, 1000, 3, &impact));
    int near = 0;
    for (const btVector3& site : qcScatterSites(lower, upper, 1000, 3, &impact))
    {
        for (int axis = 0; axis < 3; axis++)
            ck_assert(site[axis] >= lower[axis] && site[axis] <= upper[axis]);
        near += site.distance(impact) < btScalar(0.5);
    }
    ck_assert_int_gt(near, 300);
}
END_TEST

/// Splits a mesh, its pieces, and so on. Their cuts lie in the planes of earlier ones, but for rounding. Returns the
/// number of all pieces.
static size_t SplitDeep(const qcFractureDef& def, int levels, uint64_t seed)
{
    const qcFracture fracture = qcFracture_Split(def);
    ck_assert_msg(fracture.status == qc_statusOk, "%s", fracture.message.c_str());
    size_t count = fracture.pieces.size();
    double volume = 0;
    uint64_t number = 0;
    for (const qcPiece& piece : fracture.pieces)
    {
        number++;
        ck_assert(qcIsClosed(piece));
        volume += piece.volume;
        if (levels == 0 || piece.volume < 1e-4)
            continue;
        qcFractureDef part;
        part.vertices = piece.vertices;
        part.indices = piece.indices;
        qcScatterInside(&part, 8, 31 * seed + number);
        count += SplitDeep(part, levels - 1, 31 * seed + number);
    }
    ck_assert_double_eq_tol(volume + fracture.lostVolume, fracture.volume, 1e-6 * fracture.volume);
    return count;
}

START_TEST(pieces_of_pieces_are_split_again)
{
    qcFractureDef torus = qcTorusToBreak(32, 16, 1, 0.4);
    torus.sites = qcScatterSites(btVector3(btScalar(-1.4), btScalar(-1.4), btScalar(-0.4)),
                                 btVector3(btScalar(1.4), btScalar(1.4), btScalar(0.4)), 20, 1);
    ck_assert_uint_gt(SplitDeep(torus, 3, 1), 1000);
}
END_TEST

START_TEST(momentum_and_angular_momentum_are_kept)
{
    qcFractureDef box = qcBoxToBreak(1, 0.5, 2);
    qcScatterInside(&box, 60, 5);
    qcFracture fracture = qcFracture_Split(box);
    btBoxShape shape(btVector3(1, btScalar(0.5), 2));
    btVector3 inertia;
    shape.calculateLocalInertia(3, inertia);
    // The box of the tensor is the box of the mesh: no margin is added to it.
    inertia = btVector3(btScalar(0.25 + 4), btScalar(1 + 4), btScalar(1 + 0.25));
    btRigidBody body(btRigidBody::btRigidBodyConstructionInfo(3, nullptr, &shape, inertia));
    body.setWorldTransform(btTransform(btQuaternion(btVector3(1, 2, 3).normalized(), 1), btVector3(5, -2, 1)));
    body.updateInertiaTensor();
    body.setLinearVelocity(btVector3(2, 1, -3));
    body.setAngularVelocity(btVector3(-1, 4, 2));
    btVector3 momentum(0, 0, 0), angular(0, 0, 0), angularOfBodies(0, 0, 0);
    btScalar mass = 0;
    for (const qcPiece& piece : fracture.pieces)
    {
        qcPieceMotion motion = qcMotionOfPiece(body, fracture, piece);
        qcMeshShape mesh(&piece.vertices[0], sizeof(btScalar) == 4 ? qc_positionF32 : qc_positionF64, sizeof(btVector3),
                         uint32_t(piece.vertices.size()), piece.indices.data(), uint32_t(piece.indices.size() / 3));
        qcMassProperties properties = mesh.getMassProperties();
        ck_assert(properties.closed);
        btMatrix3x3 basis = motion.transform.getBasis();
        btVector3 spin = basis * (properties.inertia * (basis.transpose() * motion.angularVelocity)) * motion.mass;
        mass += motion.mass;
        momentum += motion.linearVelocity * motion.mass;
        btVector3 orbit = (motion.transform.getOrigin() - body.getWorldTransform().getOrigin())
                              .cross(motion.linearVelocity * motion.mass);
        angular += spin + orbit;
        // Bullet's bodies have the diagonal of the tensor only.
        mesh.calculateLocalInertia(motion.mass, inertia);
        angularOfBodies += basis * (inertia * (basis.transpose() * motion.angularVelocity)) + orbit;
    }
    ck_assert_double_eq_tol(double(mass), 3, 1e-4);
    ck_assert_double_le(double((momentum - body.getLinearVelocity() * 3).length()), 1e-4);
    btMatrix3x3 inverse = body.getInvInertiaTensorWorld();
    btVector3 expected = inverse.inverse() * body.getAngularVelocity();
    ck_assert_double_le(double((angular - expected).length()), 1e-3 * double(expected.length()));
    ck_assert_double_le(double((angularOfBodies - angular).length()), 1e-5 * double(expected.length()));
}
END_TEST

START_TEST(pieces_of_a_very_light_body_are_not_static)
{
    qcFractureDef box = qcBoxToBreak(1, 0.5, 2);
    qcScatterInside(&box, 60, 5);
    qcFracture fracture = qcFracture_Split(box);
    btBoxShape shape(btVector3(1, btScalar(0.5), 2));
    for (btScalar mass : {std::numeric_limits<btScalar>::min(), btScalar(0)})
    {
        btRigidBody body(btRigidBody::btRigidBodyConstructionInfo(mass, nullptr, &shape));
        for (const qcPiece& piece : fracture.pieces)
        {
            btScalar part = qcMotionOfPiece(body, fracture, piece).mass;
            ck_assert(mass > 0 ? part > 0 && std::isfinite(double(1 / part)) : part == 0);
        }
    }
}
END_TEST

START_TEST(a_piece_that_is_partly_inside_out_has_its_centre_inside_and_rotates_about_each_axis)
{
    // A box, and at one of its corners a smaller one inside out: one piece of volume 8 - 3.375.
    qcFractureDef def = qcBoxToBreak(1, 1, 1), other = qcBoxToBreak(0.75, 0.75, 0.75, true);
    for (const btVector3& vertex : other.vertices)
        def.vertices.push_back(vertex + btVector3(1, 1, 1) * btScalar(1.75));
    for (uint32_t index : other.indices)
        def.indices.push_back(8 + index);
    def.sites = {btVector3(0, 0, 0)};
    qcFracture fracture = qcFracture_Split(def);
    ck_assert_int_eq(fracture.status, qc_statusOk);
    ck_assert_uint_eq(fracture.pieces.size(), 1);
    const qcPiece& piece = fracture.pieces[0];
    ck_assert_double_eq_tol(piece.volume, 4.625, 1e-5);
    for (int axis = 0; axis < 3; axis++)
    {
        ck_assert(piece.frame.getOrigin()[axis] > 0 && piece.frame.getOrigin()[axis] < 1);
        ck_assert(piece.inertia[axis] > 0);
    }
}
END_TEST

START_TEST(bad_input_is_refused_with_its_place)
{
    qcFractureDef box = qcBoxToBreak(1, 1, 1), def = box;
    ExpectRefusal(def, "there is no site");
    def.sites = {btVector3(0, 0, 0)};
    def.indices[7] = 100;
    ExpectRefusal(def, "index 7 is 100 of 8 vertices");
    def = box;
    def.sites = {btVector3(0, 0, 0)};
    def.indices.resize(33);
    ExpectRefusal(def, "not closed: an edge of triangle 2, at -1, -1, 1");
    def.indices.resize(32);
    ExpectRefusal(def, "32 indices");
    def.indices.clear();
    ExpectRefusal(def, "0 indices");
    def = box;
    def.sites = {btVector3(0, 0, 0), btVector3(1, 0, 0), btVector3(0, 0, 0)};
    ExpectRefusal(def, "sites 0 and 2 are at the same place");
    def.sites = {btVector3(0, btScalar(NAN), 0)};
    ExpectRefusal(def, "site 0 is not finite");
    def.sites = {btVector3(0, 0, 0)};
    def.vertices[3].setX(btScalar(INFINITY));
    ExpectRefusal(def, "vertex 3 is not finite");
    def = qcBoxToBreak(1, 1, 1, true);
    def.sites = {btVector3(0, 0, 0)};
    ExpectRefusal(def, "volume is negative");
    // Each triangle twice: on the same vertices, and as a second mesh at the same place, whose corners begin elsewhere.
    def = qcBoxToBreak(1, 1, 1);
    def.sites = {btVector3(0, 0, 0)};
    def.indices.insert(def.indices.end(), box.indices.begin(), box.indices.end());
    ExpectRefusal(def, "triangle 0, at -1, -1, -1, is given twice, again as triangle 12");
    def = qcBoxToBreak(1, 1, 1);
    def.sites = {btVector3(0, 0, 0)};
    qcAddToBreak(&def, qcBoxToBreak(1, 1, 1), btVector3(0, 0, 0));
    for (size_t i = 36; i < 72; i += 3)
        std::rotate(&def.indices[i], &def.indices[i + 1], &def.indices[i] + 3);
    ExpectRefusal(def, "triangle 0, at -1, -1, -1, is given twice, again as triangle 12");
}
END_TEST

QC_RUN_TESTS("fracture", pieces_are_closed_lie_in_their_cells_and_fill_the_mesh,
             two_components_in_a_cell_make_two_pieces, cuts_through_vertices_and_along_faces_are_closed,
             cuts_through_flat_sides_leave_no_flat_or_folded_triangle, triangles_back_to_back_are_dropped,
             hollows_make_holes_in_cuts, a_hollow_belongs_to_the_piece_around_it,
             a_hollow_that_touches_the_surface_or_a_cut_is_kept,
             parts_that_touch_in_an_edge_or_a_corner_only_are_pieces_of_their_own,
             a_cut_through_many_teeth_takes_linear_time,
             parts_that_touch_each_other_in_edges_are_told_apart_in_linear_time,
             cuts_in_the_faces_of_a_turned_mesh_leave_its_surface_outside,
             sites_around_an_impact_far_from_zero_are_different,
             the_same_input_gives_the_same_pieces_and_sites_gather_around_an_impact, pieces_of_pieces_are_split_again,
             momentum_and_angular_momentum_are_kept, pieces_of_a_very_light_body_are_not_static,
             a_piece_that_is_partly_inside_out_has_its_centre_inside_and_rotates_about_each_axis,
             bad_input_is_refused_with_its_place)
