// Where the triangles of pieces come from, their materials and their texture coordinates.
#include "bullet/fracture/fracture_models.h"

#include <array>
#include <map>

// After the standard headers: check defines a macro named fail.
#include "support/suite.h"

namespace
{
constexpr bool s_isDouble = sizeof(btScalar) == sizeof(double);
constexpr double s_tolerance = s_isDouble ? 1e-12 : 2e-6;

using Vector = std::array<double, 3>;

Vector Minus(const Vector& a, const Vector& b)
{
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

Vector Cross(const Vector& a, const Vector& b)
{
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

double Dot(const Vector& a, const Vector& b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

Vector Of(const btVector3& v)
{
    return {double(v.x()), double(v.y()), double(v.z())};
}

/// A corner of a piece's triangle in the mesh's frame.
Vector CornerOf(const qcPiece& piece, size_t triangle, size_t corner)
{
    const btVector3& v = piece.vertices[piece.indices[3 * triangle + corner]];
    return Of(piece.frame * v);
}

Vector VectorArea(const Vector& a, const Vector& b, const Vector& c)
{
    Vector cross = Cross(Minus(b, a), Minus(c, a));
    return {cross[0] / 2, cross[1] / 2, cross[2] / 2};
}

std::vector<qcFractureDef> TexturedModels()
{
    std::vector<qcFractureDef> models = {qcBoxToBreak(1, 0.5, 0.7), qcTorusToBreak(24, 12, 1, 0.4), qcHollowToBreak()};
    for (qcFractureDef& model : models)
        qcScatterInside(&model, 30, 5);
    return models;
}

/// A cube cut along its axes: the normals of cuts have two components that are rounding alone.
qcFractureDef GridModel()
{
    constexpr int cells = 5;
    qcFractureDef def = qcBoxToBreak(1, 1, 1);
    auto place = [](int i) { return btScalar(2 * (i + 0.5) / cells - 1); };
    for (int i = 0; i < cells * cells * cells; i++)
        def.sites.push_back(btVector3(place(i % cells), place(i / cells % cells), place(i / cells / cells)));
    return def;
}

qcFracture Split(const qcFractureDef& def)
{
    qcFracture fracture = qcFracture_Split(def);
    ck_assert_msg(fracture.status == qc_statusOk, "%s", fracture.message.c_str());
    ck_assert_uint_gt(fracture.pieces.size(), 20);
    return fracture;
}

START_TEST(outer_triangles_cover_the_triangle_of_the_mesh_that_they_name)
{
    for (const qcFractureDef& def : TexturedModels())
    {
        qcFracture fracture = Split(def);
        ck_assert_uint_eq(fracture.triangleCount, def.indices.size() / 3);
        std::vector<Vector> covered(def.indices.size() / 3, Vector{0, 0, 0});
        for (const qcPiece& piece : fracture.pieces)
        {
            ck_assert_uint_eq(piece.sources.size(), piece.indices.size() / 3);
            for (size_t t = 0; t < piece.firstCutTriangle; t++)
            {
                Vector area = VectorArea(CornerOf(piece, t, 0), CornerOf(piece, t, 1), CornerOf(piece, t, 2));
                for (size_t axis = 0; axis < 3; axis++)
                    covered[piece.sources[t]][axis] += area[axis];
            }
        }
        for (size_t t = 0; t < covered.size(); t++)
        {
            Vector area = VectorArea(Of(def.vertices[def.indices[3 * t]]), Of(def.vertices[def.indices[3 * t + 1]]),
                                     Of(def.vertices[def.indices[3 * t + 2]]));
            for (size_t axis = 0; axis < 3; axis++)
                ck_assert_double_eq_tol(covered[t][axis], area[axis], s_tolerance);
        }
    }
}
END_TEST

START_TEST(triangles_in_cuts_lie_halfway_between_their_site_and_the_one_they_name)
{
    for (const qcFractureDef& def : TexturedModels())
    {
        qcFracture fracture = Split(def);
        ck_assert_uint_eq(fracture.siteCount, def.sites.size());
        size_t cuts = 0;
        for (const qcPiece& piece : fracture.pieces)
            for (size_t t = piece.firstCutTriangle; t < piece.sources.size(); t++, cuts++)
            {
                ck_assert_uint_lt(piece.sources[t], def.sites.size());
                ck_assert_uint_ne(piece.sources[t], piece.site);
                Vector own = Of(def.sites[piece.site]), other = Of(def.sites[piece.sources[t]]);
                for (size_t c = 0; c < 3; c++)
                {
                    Vector a = Minus(CornerOf(piece, t, c), own), b = Minus(CornerOf(piece, t, c), other);
                    ck_assert_double_eq_tol(Dot(a, a), Dot(b, b), 10 * s_tolerance);
                }
            }
        ck_assert_uint_gt(cuts, 100);
    }
}
END_TEST

/// A texture that is linear in the position: each corner's coordinates are known wherever it lies.
double ExpectedOf(const Vector& p, size_t k)
{
    return k == 0 ? 0.3 * p[0] - 0.2 * p[1] + 0.1 * p[2] + 4 : 0.5 * p[2] + 0.1 * p[0];
}

qcTextureDef LinearTexture(const qcFractureDef& def)
{
    qcTextureDef texture;
    for (uint32_t index : def.indices)
        for (size_t k = 0; k < 2; k++)
            texture.coordinates.push_back(float(ExpectedOf(Of(def.vertices[index]), k)));
    for (size_t t = 0; t < def.indices.size() / 3; t++)
        texture.materials.push_back(uint32_t(t % 7));
    texture.cutMaterial = 9;
    texture.cutScale = 2.5;
    return texture;
}

START_TEST(the_surface_keeps_its_materials_and_its_texture)
{
    for (const qcFractureDef& def : TexturedModels())
    {
        qcFracture fracture = Split(def);
        for (const qcPiece& piece : fracture.pieces)
        {
            qcPieceTexture texture = qcTexturePiece(def, piece, LinearTexture(def));
            ck_assert_int_eq(texture.status, qc_statusOk);
            ck_assert_uint_eq(texture.coordinates.size(), 6 * piece.sources.size());
            ck_assert_uint_eq(texture.materials.size(), piece.sources.size());
            std::vector<btVector3> weights = qcWeightsOfPiece(def, piece);
            ck_assert_uint_eq(weights.size(), 3 * size_t(piece.firstCutTriangle));
            for (size_t t = 0; t < piece.sources.size(); t++)
            {
                bool isCut = t >= piece.firstCutTriangle;
                ck_assert_uint_eq(texture.materials[t], isCut ? 9 : piece.sources[t] % 7);
                for (size_t c = 0; c < 3 && !isCut; c++)
                {
                    for (size_t k = 0; k < 2; k++)
                        ck_assert_double_eq_tol(double(texture.coordinates[6 * t + 2 * c + k]),
                                                ExpectedOf(CornerOf(piece, t, c), k), 1e-5);
                    const btVector3& weight = weights[3 * t + c];
                    ck_assert_double_eq_tol(double(weight.x() + weight.y() + weight.z()), 1, 1e-6);
                    for (int i = 0; i < 3; i++)
                        ck_assert(weight[i] >= 0 && weight[i] <= 1);
                }
            }
        }
    }
}
END_TEST

START_TEST(the_texture_inside_is_planar_in_units_of_length_and_equal_on_both_sides_of_a_cut)
{
    std::vector<qcFractureDef> models = TexturedModels();
    models.push_back(GridModel());
    for (const qcFractureDef& def : models)
    {
        qcFracture fracture = Split(def);
        // Coordinates by cut and position, from the lower site's side.
        std::map<std::array<uint32_t, 2>, std::vector<std::array<double, 5>>> lower;
        size_t equal = 0;
        for (bool isHigh : {false, true})
            for (const qcPiece& piece : fracture.pieces)
            {
                qcPieceTexture texture = qcTexturePiece(def, piece, LinearTexture(def));
                for (size_t t = piece.firstCutTriangle; t < piece.sources.size(); t++)
                {
                    if ((piece.site > piece.sources[t]) != isHigh)
                        continue;
                    auto& corners =
                        lower[{std::min(piece.site, piece.sources[t]), std::max(piece.site, piece.sources[t])}];
                    for (size_t c = 0; c < 3; c++)
                    {
                        const float* at = &texture.coordinates[6 * t + 2 * c];
                        const float* next = &texture.coordinates[6 * t + 2 * ((c + 1) % 3)];
                        Vector p = CornerOf(piece, t, c), edge = Minus(CornerOf(piece, t, (c + 1) % 3), p);
                        ck_assert_double_eq_tol(std::hypot(double(next[0] - at[0]), double(next[1] - at[1])),
                                                2.5 * std::sqrt(Dot(edge, edge)), 1e-5);
                        if (!isHigh)
                            corners.push_back({p[0], p[1], p[2], double(at[0]), double(at[1])});
                        for (const auto& corner : corners)
                        {
                            Vector apart = Minus({corner[0], corner[1], corner[2]}, p);
                            if (!isHigh || Dot(apart, apart) > 1e-12)
                                continue;
                            equal++;
                            ck_assert_double_eq_tol(corner[3], double(at[0]), 2e-5);
                            ck_assert_double_eq_tol(corner[4], double(at[1]), 2e-5);
                        }
                    }
                }
            }
        ck_assert_uint_gt(equal, 100);
    }
}
END_TEST

START_TEST(a_mesh_of_any_size_has_the_weights_and_planes_of_its_likeness)
{
    const btScalar exponents[] = {-15, 15, s_isDouble ? -90 : -20, s_isDouble ? 90 : 20};
    qcFractureDef def = qcTorusToBreak(8, 5, 1, 0.4);
    qcScatterInside(&def, 10, 5);
    const qcFracture fracture = qcFracture_Split(def);
    ck_assert_int_eq(fracture.status, qc_statusOk);
    qcTextureDef texture;
    texture.cutScale = 1;
    for (const btScalar exponent : exponents)
    {
        // By powers of two: pieces are scaled bit by bit, and so is what is computed of them.
        const btScalar scale = std::exp2(std::round(exponent * btScalar(3.3219)));
        qcFractureDef scaled = def;
        for (btVector3& vertex : scaled.vertices)
            vertex *= scale;
        for (btVector3& site : scaled.sites)
            site *= scale;
        const qcFracture pieces = qcFracture_Split(scaled);
        ck_assert_msg(pieces.status == qc_statusOk, "%s", pieces.message.c_str());
        ck_assert_uint_eq(pieces.pieces.size(), fracture.pieces.size());
        texture.cutScale = 1 / double(scale);
        for (size_t i = 0; i < pieces.pieces.size(); i++)
        {
            const std::vector<btVector3> expected = qcWeightsOfPiece(def, fracture.pieces[i]),
                                         weights = qcWeightsOfPiece(scaled, pieces.pieces[i]);
            ck_assert_uint_eq(weights.size(), expected.size());
            for (size_t k = 0; k < weights.size(); k++)
                ck_assert(weights[k] == expected[k]);
            qcTextureDef plain;
            plain.cutScale = 1;
            ck_assert(qcTexturePiece(scaled, pieces.pieces[i], texture).coordinates ==
                      qcTexturePiece(def, fracture.pieces[i], plain).coordinates);
        }
    }
}
END_TEST

START_TEST(far_from_zero_both_sides_of_a_cut_have_equal_coordinates)
{
    qcFractureDef def = qcTorusToBreak(24, 12, 1, 0.4);
    for (btVector3& vertex : def.vertices)
        vertex += btVector3(3000, -4000, 5000);
    qcScatterInside(&def, 60, 3);
    // Coordinates by cut and place: places within 5 mm count as one.
    std::map<std::array<long, 5>, std::vector<std::array<double, 2>>> seen;
    const qcFracture fracture = qcFracture_Split(def);
    size_t equal = 0;
    for (const qcPiece& piece : fracture.pieces)
    {
        const qcPieceTexture texture = qcTexturePiece(def, piece, qcTextureDef());
        for (size_t t = piece.firstCutTriangle; t < piece.sources.size(); t++)
            for (size_t c = 0; c < 3; c++)
            {
                const Vector p = CornerOf(piece, t, c);
                const auto [low, high] = std::minmax(piece.site, piece.sources[t]);
                auto& here = seen[{long(low), long(high), std::lround(p[0] * 200), std::lround(p[1] * 200),
                                   std::lround(p[2] * 200)}];
                const float* at = &texture.coordinates[6 * t + 2 * c];
                for (const auto& other : here)
                {
                    equal++;
                    ck_assert_double_eq_tol(other[0], double(at[0]), 0.01);
                    ck_assert_double_eq_tol(other[1], double(at[1]), 0.01);
                }
                here.push_back({double(at[0]), double(at[1])});
            }
    }
    ck_assert_uint_gt(equal, 100);
}
END_TEST

START_TEST(a_texture_of_another_mesh_is_refused)
{
    qcFractureDef def = TexturedModels()[0], coarse = qcBoxToBreak(1, 1, 1);
    qcFracture fracture = Split(def);
    qcPiece piece = fracture.pieces[0];
    qcTextureDef texture = LinearTexture(def);
    texture.coordinates.pop_back();
    qcPieceTexture refused = qcTexturePiece(def, piece, texture);
    ck_assert_int_eq(refused.status, qc_statusBadInput);
    ck_assert_str_eq(refused.message.c_str(), "qcTexturePiece: 71 texture coordinates for a mesh of 12 triangles, "
                                              "which has six a triangle");
    ck_assert_str_eq(qcLastMessage(), refused.message.c_str());
    texture = LinearTexture(def);
    texture.materials.push_back(0);
    ck_assert_int_eq(qcTexturePiece(def, piece, texture).status, qc_statusBadInput);
    // Neither list is needed.
    qcPieceTexture plain = qcTexturePiece(def, piece, qcTextureDef());
    ck_assert_int_eq(plain.status, qc_statusOk);
    ck_assert_uint_eq(plain.materials.back(), 1);
    coarse.indices.resize(3);
    if (piece.firstCutTriangle > 0)
        piece.sources[0] = 5;
    else
        piece.indices[0] = 1000;
    refused = qcTexturePiece(coarse, piece, qcTextureDef());
    ck_assert_int_eq(refused.status, qc_statusBadInput);
    ck_assert(refused.coordinates.empty() && refused.materials.empty());
    ck_assert(qcWeightsOfPiece(coarse, piece).empty());
    // A piece from within has no triangle of the surface.
    auto isInner = [](const qcPiece& inner) { return inner.firstCutTriangle == 0; };
    qcFractureDef fine = qcBoxToBreak(1, 1, 1);
    qcScatterInside(&fine, 200, 5);
    const qcFracture parts = Split(fine);
    const auto inner = std::find_if(parts.pieces.begin(), parts.pieces.end(), isInner);
    ck_assert(inner != parts.pieces.end());
    ck_assert_int_eq(qcTexturePiece(qcFractureDef(), *inner, qcTextureDef()).status, qc_statusBadInput);
    piece = fracture.pieces[0];
    piece.sources.pop_back();
    ck_assert_int_eq(qcTexturePiece(def, piece, qcTextureDef()).status, qc_statusBadInput);
}
END_TEST
} // namespace

QC_RUN_TESTS("fracture_texture", outer_triangles_cover_the_triangle_of_the_mesh_that_they_name,
             triangles_in_cuts_lie_halfway_between_their_site_and_the_one_they_name,
             the_surface_keeps_its_materials_and_its_texture,
             the_texture_inside_is_planar_in_units_of_length_and_equal_on_both_sides_of_a_cut,
             a_mesh_of_any_size_has_the_weights_and_planes_of_its_likeness,
             far_from_zero_both_sides_of_a_cut_have_equal_coordinates, a_texture_of_another_mesh_is_refused)
