// Meshes of any size anywhere break as one of length 1 at the origin does, however far away or close together the sites
// are; what btScalar or double can't hold is refused.
#include "quickcullide/bullet_fracture.h"

#include "bullet/fracture/fracture_models.h"
#include "support/suite.h"

#include <array>
#include <limits>
#include <random>
#include <string>
#include <vector>

namespace
{
const bool s_isFloat = sizeof(btScalar) == sizeof(float);
const double s_scaledRounding = s_isFloat ? 2e-6 : 1e-11; ///< of a piece of length 1

typedef std::array<double, 3> Point3;

//  ---- input -----------------------------------------------------------------------------------------

/// Scales and moves vertices and sites, with one rounding each.
qcFractureDef Moved(qcFractureDef def, double scale, const Point3& place)
{
    for (std::vector<btVector3>* points : {&def.vertices, &def.sites})
        for (btVector3& p : *points)
            for (int axis = 0; axis < 3; axis++)
                p[axis] = btScalar(double(p[axis]) * scale + place[size_t(axis)]);
    return def;
}

/// A box, a torus and a box with a hollow, each with sites inside.
std::vector<qcFractureDef> MakeCases(uint32_t siteCount)
{
    std::vector<qcFractureDef> cases = {qcBoxToBreak(1, 0.5, 2), qcTorusToBreak(24, 12, 1, 0.4), qcHollowToBreak()};
    for (qcFractureDef& def : cases)
        qcScatterInside(&def, siteCount, siteCount);
    return cases;
}

//  ---- checks ----------------------------------------------------------------------------------------

Point3 PointOf(const btVector3& v)
{
    return {double(v[0]), double(v[1]), double(v[2])};
}

/// A vertex of a piece in the mesh's frame.
Point3 InMesh(const qcPiece& piece, const btVector3& vertex)
{
    Point3 p, v = PointOf(vertex), origin = PointOf(piece.frame.getOrigin());
    for (int k = 0; k < 3; k++)
    {
        Point3 row = PointOf(piece.frame.getBasis()[k]);
        p[size_t(k)] = row[0] * v[0] + row[1] * v[1] + row[2] * v[2] + origin[size_t(k)];
    }
    return p;
}

/// Winding number of the triangles around a point, by solid angles (Van Oosterom, Strackee: The solid angle of a plane
/// triangle, 1983).
double WindingOf(const std::vector<Point3>& vertices, const std::vector<uint32_t>& indices, const Point3& point)
{
    double sum = 0;
    for (size_t i = 0; i < indices.size(); i += 3)
    {
        double e[3][3], length[3];
        for (size_t c = 0; c < 3; c++)
        {
            for (size_t k = 0; k < 3; k++)
                e[c][k] = vertices[indices[i + c]][k] - point[k];
            length[c] = std::sqrt(e[c][0] * e[c][0] + e[c][1] * e[c][1] + e[c][2] * e[c][2]);
        }
        auto dot = [&](int a, int b) { return e[a][0] * e[b][0] + e[a][1] * e[b][1] + e[a][2] * e[b][2]; };
        double det = e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) +
                     e[0][1] * (e[1][2] * e[2][0] - e[1][0] * e[2][2]) +
                     e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0]);
        sum += 2 * std::atan2(det, length[0] * length[1] * length[2] + dot(0, 1) * length[2] + dot(1, 2) * length[0] +
                                       dot(2, 0) * length[1]);
    }
    return sum / (4 * 3.14159265358979323846);
}

/// A point relative to a place in the mesh's frame, divided by a scale: angles and volumes neither overflow nor cancel.
Point3 Near(const Point3& p, const Point3& place, double scale)
{
    return {(p[0] - place[0]) / scale, (p[1] - place[1]) / scale, (p[2] - place[2]) / scale};
}

/// The volume inside triangles, in cubes of the scale.
double VolumeOf(const std::vector<btVector3>& vertices, const std::vector<uint32_t>& indices, double scale)
{
    std::vector<btVector3> scaled;
    for (const btVector3& v : vertices)
        scaled.emplace_back(btScalar(double(v[0]) / scale), btScalar(double(v[1]) / scale),
                            btScalar(double(v[2]) / scale));
    return qcVolumeOf(scaled, indices);
}

/// Checks that each point around the place is in as many pieces as in the mesh: none or one.
void CheckNoOverlap(const qcFractureDef& def, const qcFracture& fracture, double scale, const Point3& place,
                    const std::string& what)
{
    std::vector<Point3> mesh;
    for (const btVector3& vertex : def.vertices)
        mesh.push_back(Near(PointOf(vertex), place, scale));
    std::vector<std::vector<Point3>> pieces;
    for (const qcPiece& piece : fracture.pieces)
    {
        pieces.emplace_back();
        for (const btVector3& vertex : piece.vertices)
            pieces.back().push_back(Near(InMesh(piece, vertex), place, scale));
    }
    std::mt19937 random(1);
    for (int i = 0; i < 40; i++)
    {
        auto coordinate = [&] { return 3.2 * (double(random()) / 4294967296.0 - 0.5); };
        Point3 point = {coordinate(), coordinate(), coordinate()};
        double winding = 0;
        for (size_t k = 0; k < pieces.size(); k++)
            winding += WindingOf(pieces[k], fracture.pieces[k].indices, point);
        double expected = WindingOf(mesh, def.indices, point);
        ck_assert_msg(std::fabs(winding - expected) < 0.01, "%s: %g, %g, %g is in %g pieces, not in %g", what.c_str(),
                      point[0], point[1], point[2], winding, expected);
    }
}

/// Checks the pieces of a mesh that is about `scale` long, at `place`: closed, with the volume of the mesh, disjoint.
qcFracture CheckPieces(const qcFractureDef& def, double scale, const Point3& place, const std::string& what)
{
    qcFracture fracture = qcFracture_Split(def);
    ck_assert_msg(fracture.status == qc_statusOk, "%s: %s", what.c_str(), fracture.message.c_str());
    double sum = 0, cube = scale * scale * scale;
    for (const qcPiece& piece : fracture.pieces)
    {
        ck_assert_msg(qcIsClosed(piece), "%s: a piece is open", what.c_str());
        double volume = VolumeOf(piece.vertices, piece.indices, scale);
        ck_assert_msg(std::fabs(volume - piece.volume / cube) <= 20 * s_scaledRounding, "%s: a piece is %g, not %g",
                      what.c_str(), volume, piece.volume / cube);
        ck_assert(piece.volume > 0);
        sum += piece.volume / cube;
    }
    std::vector<btVector3> vertices = def.vertices;
    for (btVector3& vertex : vertices)
        vertex -= def.vertices[0];
    double whole = VolumeOf(vertices, def.indices, scale), lost = fracture.lostVolume / cube;
    ck_assert_msg(std::fabs(sum + lost - whole) <= 4 * s_scaledRounding * whole, "%s: pieces are %.9g of %.9g",
                  what.c_str(), sum, whole);
    ck_assert_double_eq_tol(fracture.volume / cube, whole, 4 * s_scaledRounding * whole);
    ck_assert_double_le(lost, 1e-6 * whole);
    CheckNoOverlap(def, fracture, scale, place, what);
    return fracture;
}

void ExpectRefusalAtScale(const qcFractureDef& def, const std::string& part)
{
    qcFracture fracture = qcFracture_Split(def);
    ck_assert_int_eq(fracture.status, qc_statusBadInput);
    ck_assert_uint_eq(fracture.pieces.size(), 0);
    ck_assert_msg(fracture.message.find(part) != std::string::npos, "\"%s\" lacks \"%s\"", fracture.message.c_str(),
                  part.c_str());
}

bool HavePointsAtTheSamePlace(const std::vector<btVector3>& points)
{
    std::vector<Point3> sorted;
    for (const btVector3& p : points)
        sorted.push_back(PointOf(p));
    std::sort(sorted.begin(), sorted.end());
    return std::adjacent_find(sorted.begin(), sorted.end()) != sorted.end();
}

/// Checks that two fractures differ by a power of two alone: each number is scaled by it without rounding.
void CheckScaled(const qcFracture& one, const qcFracture& other, int exponent)
{
    double scale = std::ldexp(1, exponent);
    auto times = [&](const btVector3& v) { return v * btScalar(scale); };
    ck_assert_uint_eq(one.pieces.size(), other.pieces.size());
    ck_assert(other.volume == std::ldexp(one.volume, 3 * exponent));
    ck_assert(other.lostVolume == std::ldexp(one.lostVolume, 3 * exponent));
    for (size_t i = 0; i < one.pieces.size(); i++)
    {
        const qcPiece &a = one.pieces[i], &b = other.pieces[i];
        ck_assert(a.indices == b.indices && a.site == b.site && a.firstCutTriangle == b.firstCutTriangle);
        ck_assert(b.volume == std::ldexp(a.volume, 3 * exponent));
        ck_assert(b.frame.getBasis() == a.frame.getBasis());
        ck_assert(b.frame.getOrigin() == times(a.frame.getOrigin()));
        ck_assert_uint_eq(a.vertices.size(), b.vertices.size());
        for (size_t k = 0; k < a.vertices.size(); k++)
            ck_assert(b.vertices[k] == times(a.vertices[k]));
    }
}
} // namespace

START_TEST(meshes_of_any_size_fall_into_pieces_that_fill_them)
{
    for (const qcFractureDef& def : MakeCases(21))
    {
        for (int exponent = -30; exponent <= 30; exponent += 2)
            CheckPieces(Moved(def, std::pow(10, exponent), {}), std::pow(10, exponent), {},
                        "1e" + std::to_string(exponent));
        // In between voro++ began to lose cuts.
        for (double scale : {2e-5, 2e-6, 2e-7})
            CheckPieces(Moved(def, scale, {}), scale, {}, std::to_string(scale));
        for (double scale : {1e-90, 1e90})
            if (!s_isFloat)
                CheckPieces(Moved(def, scale, {}), scale, {}, "double");
    }
}
END_TEST

START_TEST(a_mesh_scaled_by_a_power_of_two_falls_into_the_pieces_scaled)
{
    for (const qcFractureDef& def : MakeCases(30))
    {
        qcFracture one = qcFracture_Split(def);
        ck_assert_int_eq(one.status, qc_statusOk);
        for (int exponent : {-60, -40, -17, -1, 3, 25, 60, 100})
            CheckScaled(one, qcFracture_Split(Moved(def, std::ldexp(1, exponent), {})), exponent);
    }
}
END_TEST

START_TEST(meshes_far_from_the_origin_fall_into_pieces_that_fill_them)
{
    // At 1e6 a float has a resolution of 1 / 16, as a double at 1e15 has one of 1 / 8: frames lie that far from
    // centres.
    for (double distance : {10.0, 1e3, 1e6, 1e12, 1e15})
        for (const qcFractureDef& def : MakeCases(21))
        {
            Point3 place = {distance, -distance / 2, distance / 3};
            qcFractureDef moved = Moved(def, 1, place);
            if ((s_isFloat && distance > 1e6) || HavePointsAtTheSamePlace(moved.sites))
                continue;
            const qcFracture fracture = CheckPieces(moved, 1, place, "at " + std::to_string(distance));
            ck_assert_uint_ge(fracture.bonds.size() + 1, fracture.pieces.size()); // they hang together
        }
}
END_TEST

START_TEST(sites_too_far_away_to_matter_change_nothing)
{
    for (const qcFractureDef& def : MakeCases(21))
    {
        qcFracture expected = qcFracture_Split(def);
        for (double distance : {1e3, 1e8, 1e16, 1e30, double(std::numeric_limits<btScalar>::max())})
        {
            qcFractureDef more = def;
            more.sites.push_back(btVector3(btScalar(distance), 0, 1));
            more.sites.push_back(btVector3(0, btScalar(-distance), btScalar(distance)));
            CheckScaled(expected, CheckPieces(more, 1, {}, "a site at " + std::to_string(distance)), 0);
        }
    }
}
END_TEST

START_TEST(sites_that_are_all_far_away_cut_where_their_bisectors_lie)
{
    // At any distance the planes between them are y, z = 0.4 (k + 1/2).
    for (double distance : {3.0, 1e3, 1e8, 1e16, 1e30, 3e38, 1e100, 1e140})
    {
        if (s_isFloat && distance > 3e38)
            continue;
        qcFractureDef def = qcBoxToBreak(1, 1, 1);
        for (int k = 0; k < 25; k++)
            def.sites.push_back(
                btVector3(btScalar(distance), btScalar(0.4 * (k % 5 - 2)), btScalar(0.4 * (k / 5 - 2))));
        qcFracture fracture = CheckPieces(def, 1, {}, std::to_string(distance));
        ck_assert_uint_eq(fracture.pieces.size(), 25);
        for (const qcPiece& piece : fracture.pieces)
            ck_assert_double_eq_tol(piece.volume, 0.32, 4 * s_scaledRounding);
    }
}
END_TEST

START_TEST(planes_between_distant_sites_are_rounded_only_once)
{
    // Both pairs of sites have the plane 2 x - 3 y + 6 z = 0 between them: (3, 2, 0) and (0, 6, 3) lie in it. Squares
    // of distances from the far ones have twice as many bits as a btScalar.
    double a = std::ldexp(1, s_isFloat ? 19 : 48), b = a * 7 / 8;
    qcFractureDef near = qcBoxToBreak(1, 1, 1), far = near;
    for (int side : {-1, 1})
    {
        near.sites.push_back(btVector3(btScalar(2 * side), btScalar(-3 * side), btScalar(6 * side)));
        far.sites.push_back(near.sites.back() + btVector3(btScalar(3 * a), btScalar(2 * a + 6 * b), btScalar(3 * b)));
    }
    CheckScaled(CheckPieces(near, 1, {}, "near"), CheckPieces(far, 1, {}, "far"), 0);
}
END_TEST

START_TEST(sites_on_a_distant_sphere_cut_pieces_that_fill_the_mesh)
{
    // Their distances differ by rounding: the planes between them are spread over the mesh.
    std::mt19937 random(3);
    auto coordinate = [&] { return double(random()) / 2147483648.0 - 1; };
    for (int exponent = 1; exponent <= (s_isFloat ? 7 : 16); exponent++)
        for (qcFractureDef def : MakeCases(1))
        {
            def.sites.clear();
            for (int i = 0; i < 25; i++)
            {
                Point3 p = {coordinate(), coordinate(), coordinate()};
                double scale = std::pow(10, exponent) / std::sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
                def.sites.push_back(btVector3(btScalar(p[0] * scale), btScalar(p[1] * scale), btScalar(p[2] * scale)));
            }
            CheckPieces(def, 1, {}, "a sphere of 1e" + std::to_string(exponent));
        }
}
END_TEST

START_TEST(random_sites_near_far_and_close_together_cut_pieces_that_fill_the_mesh)
{
    for (uint32_t seed = 1; seed <= 40; seed++)
        for (qcFractureDef def : MakeCases(10))
        {
            std::mt19937 random(seed);
            auto coordinate = [&](double size) { return btScalar(size * (double(random()) / 2147483648.0 - 1)); };
            for (int i = 0; i < 6; i++)
            {
                double size = std::pow(10, 1 + int(random() % 36)), gap = std::pow(10, -int(random() % 8));
                def.sites.push_back(btVector3(coordinate(size), coordinate(size), coordinate(size)));
                btVector3 step(coordinate(gap), coordinate(gap), coordinate(gap));
                def.sites.push_back(def.sites[size_t(i)] + step);
            }
            if (!HavePointsAtTheSamePlace(def.sites))
                CheckPieces(def, 1, {}, "seed " + std::to_string(seed));
        }
}
END_TEST

START_TEST(sites_however_close_to_each_other_have_a_cut_between_them)
{
    for (double gap : {1e-3, 1e-6, 1e-9, 1e-20, 1e-37})
    {
        qcFractureDef def = qcBoxToBreak(1, 1, 1);
        def.sites = {btVector3(0, 0, 0), btVector3(btScalar(gap), 0, 0)};
        qcFracture halves = CheckPieces(def, 1, {}, std::to_string(gap));
        ck_assert_uint_eq(halves.pieces.size(), 2);
        ck_assert_double_eq_tol(halves.pieces[0].volume, 4 * (1 + gap / 2), 4 * s_scaledRounding);
        qcScatterInside(&def, 20, 20);
        def.sites.push_back(btVector3(0, 0, 0));
        def.sites.push_back(btVector3(btScalar(gap), 0, 0));
        ck_assert_uint_eq(CheckPieces(def, 1, {}, "among others").pieces.size(), 22);
    }
}
END_TEST

START_TEST(nearly_regular_lattices_of_sites_cut_pieces_that_fill_the_mesh)
{
    // voro++ 0.4.6 loses neighbours in these.
    struct Lattice
    {
        int count;
        double step, shift;
    };
    for (const Lattice& lattice : std::vector<Lattice>{
             {6, 0x1p-4, 1e-7}, {6, 0x1p-8, 1e-7}, {4, 0x1p-16, 1e-2}, {5, 0x1p-16, 1e-3}, {6, 0x1p-17, 1e-3}})
        for (qcFractureDef def : MakeCases(1))
        {
            def.sites.clear();
            for (int i = 0, n = lattice.count; i < n * n * n; i++)
                def.sites.push_back(
                    btVector3(btScalar(lattice.step * (i % n - n / 2 + lattice.shift * std::sin(7 * i))),
                              btScalar(lattice.step * (i / n % n - n / 2 + lattice.shift * std::sin(5 * i))),
                              btScalar(lattice.step * (i / n / n - n / 2 + lattice.shift * std::sin(3 * i)))));
            CheckPieces(def, 1, {}, "a lattice of " + std::to_string(lattice.step));
        }
}
END_TEST

START_TEST(input_beyond_the_range_of_btscalar_or_double_is_refused_with_its_place)
{
    qcFractureDef def = qcBoxToBreak(1, 1, 1);
    def.sites = {btVector3(0, 0, 0), btVector3(1, 0, 0)};
    double least = double(std::numeric_limits<btScalar>::min()),
           greatest = double(std::numeric_limits<btScalar>::max());
    ExpectRefusalAtScale(Moved(def, least, {}), "vertices 0 and 5 are at distance");
    ExpectRefusalAtScale(Moved(def, greatest, {}), "vertices 0 and 5 are at distance");
    ExpectRefusalAtScale(Moved(def, 0, {1, 1, 1}), "sites 0 and 1 are at the same place");
    def.sites.pop_back();
    ExpectRefusalAtScale(Moved(def, 0, {1, 1, 1}), "are at distance 0");
    def.vertices.push_back(btVector3(btScalar(greatest), 0, 0)); // of no triangle
    ck_assert_int_eq(qcFracture_Split(def).status, qc_statusOk);
    def = qcBoxToBreak(1, 1, 1e-13);
    def.sites = {btVector3(0, 0, 0)};
    ExpectRefusalAtScale(def, "too thin");
    def.sites = {btVector3(0, 0, 0), btVector3(0, btScalar(-INFINITY), 0)};
    ExpectRefusalAtScale(def, "site 1 is not finite");
    if (s_isFloat)
        return;
    def = qcBoxToBreak(1, 1, 1);
    def.sites = {btVector3(0, 0, 0)};
    ExpectRefusalAtScale(Moved(def, 1e110, {}), "leaves the range of double");
    ExpectRefusalAtScale(Moved(def, 1e-102, {}), "leaves the range of double");
    def.sites = {btVector3(btScalar(1e160), 0, 0), btVector3(0, btScalar(1e155), 0)};
    ExpectRefusalAtScale(def, "site 1, the nearest");
    // In units of the mesh's length they are at the same place.
    const btScalar tiny = std::numeric_limits<btScalar>::denorm_min();
    def.sites = {btVector3(1, 0, 0), btVector3(0, 0, 0), btVector3(0, 1, 0), btVector3(0, tiny, tiny)};
    ExpectRefusalAtScale(def, "sites 1 and 3 are at the same place");
}
END_TEST

QC_RUN_TESTS("fracture scale", meshes_of_any_size_fall_into_pieces_that_fill_them,
             a_mesh_scaled_by_a_power_of_two_falls_into_the_pieces_scaled,
             meshes_far_from_the_origin_fall_into_pieces_that_fill_them, sites_too_far_away_to_matter_change_nothing,
             sites_that_are_all_far_away_cut_where_their_bisectors_lie,
             planes_between_distant_sites_are_rounded_only_once,
             sites_on_a_distant_sphere_cut_pieces_that_fill_the_mesh,
             random_sites_near_far_and_close_together_cut_pieces_that_fill_the_mesh,
             sites_however_close_to_each_other_have_a_cut_between_them,
             nearly_regular_lattices_of_sites_cut_pieces_that_fill_the_mesh,
             input_beyond_the_range_of_btscalar_or_double_is_refused_with_its_place)
