// A cut face of a piece lies in the bisector of two sites. All faces in one bisector are on one side or the other, and
// faces on one side don't overlap, as their pieces don't. Overlaps of triangles: Sutherland, Hodgman: Reentrant polygon
// clipping, 1974.
#include "fracture/bonds.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

namespace
{
// In squared units: below it, corners that rounding moved make areas of pieces that touch along an edge.
constexpr double s_minArea = 1e-13;
// In units, of sites and corners of single precision: narrower areas are of pieces that touch along an edge.
constexpr double s_minRounding = 1e-6;
// Areas that differ by less than this part are equal but for rounding.
constexpr double s_sameArea = 1e-10;

using Triangle = std::array<qcClipPoint, 3>;

/// The triangles of a piece in one cut.
struct CutFace
{
    uint32_t lowCell, highCell;
    bool isHigh; ///< the piece is in the cell of the higher number
    uint32_t piece;
    std::vector<Triangle> triangles;
};

/// A part of a plane: its area, the integral of positions over it, its vector area, and its box.
struct Area
{
    double area = 0;
    qcClipPoint first = {0, 0, 0}, normal = {0, 0, 0};
    qcClipPoint lower = {HUGE_VAL, HUGE_VAL, HUGE_VAL}, upper = {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};

    void Add(const qcClipPoint& a, const qcClipPoint& b, const qcClipPoint& c)
    {
        qcClipPoint cross = qcCrossOf(qcMinus(b, a), qcMinus(c, a));
        double size = std::sqrt(qcDotOf(cross, cross)) / 2;
        area += size;
        for (size_t axis = 0; axis < 3; axis++)
        {
            first[axis] += size * (a[axis] + b[axis] + c[axis]) / 3;
            normal[axis] += cross[axis] / 2;
            lower[axis] = std::min({lower[axis], a[axis], b[axis], c[axis]});
            upper[axis] = std::max({upper[axis], a[axis], b[axis], c[axis]});
        }
    }

    /// True if it is a sliver of rounding, or nothing.
    bool IsThin(double rounding) const
    {
        const qcClipPoint extent = qcMinus(upper, lower);
        return area < s_minArea || area < rounding * std::sqrt(qcDotOf(extent, extent));
    }
};

Area AreaOf(const CutFace& face)
{
    Area area;
    for (const auto& corner : face.triangles)
        area.Add(corner[0], corner[1], corner[2]);
    return area;
}

/// Clips a convex polygon by an edge of a counterclockwise triangle. `across`: normal of the edge in the triangle's
/// plane, to the outside.
void ClipPolygon(const qcClipPoint& on, const qcClipPoint& across, std::vector<qcClipPoint>* polygon)
{
    std::vector<qcClipPoint> kept;
    for (size_t i = 0; i < polygon->size(); i++)
    {
        const qcClipPoint &from = (*polygon)[i], &to = (*polygon)[(i + 1) % polygon->size()];
        double start = qcDotOf(qcMinus(from, on), across), end = qcDotOf(qcMinus(to, on), across);
        if (start <= 0)
            kept.push_back(from);
        if ((start < 0 && end > 0) || (start > 0 && end < 0))
        {
            qcClipPoint crossing;
            for (size_t axis = 0; axis < 3; axis++)
                crossing[axis] = from[axis] + (to[axis] - from[axis]) * (start / (start - end));
            kept.push_back(crossing);
        }
    }
    polygon->swap(kept);
}

qcClipPoint NormalOf(const Triangle& corner)
{
    return qcCrossOf(qcMinus(corner[1], corner[0]), qcMinus(corner[2], corner[0]));
}

/// The normal of a face's largest triangle. Where a cut crosses a flat side of two triangles, some have no area, and
/// the face of a mesh that crosses itself has triangles of both orientations.
qcClipPoint PlaneNormal(const CutFace& face)
{
    qcClipPoint largest = {0, 0, 0};
    for (const Triangle& corner : face.triangles)
    {
        const qcClipPoint normal = NormalOf(corner);
        if (qcDotOf(normal, normal) > qcDotOf(largest, largest))
            largest = normal;
    }
    return largest;
}

/// True if the boxes of two triangles meet, up to rounding: both lie in one plane, but for that.
bool BoxesMeet(const Triangle& a, const Triangle& b, double rounding)
{
    for (size_t axis = 0; axis < 3; axis++)
    {
        auto [lowA, highA] = std::minmax({a[0][axis], a[1][axis], a[2][axis]});
        auto [lowB, highB] = std::minmax({b[0][axis], b[1][axis], b[2][axis]});
        if (lowA > highB + 2 * rounding || lowB > highA + 2 * rounding)
            return false;
    }
    return true;
}

/// The overlap of two faces on different sides of a cut. O(triangles * triangles).
Area Overlap(const CutFace& one, const CutFace& other, double rounding)
{
    Area area;
    std::vector<qcClipPoint> polygon;
    const qcClipPoint plane = PlaneNormal(other);
    for (const Triangle& corner : other.triangles)
    {
        const double turn = qcDotOf(NormalOf(corner), plane);
        const double side = turn > 0 ? 1 : -1;
        for (const Triangle& subject : one.triangles)
        {
            if (turn == 0 || !BoxesMeet(subject, corner, rounding))
                continue;
            polygon.assign(subject.begin(), subject.end());
            for (size_t edge = 0; edge < 3 && !polygon.empty(); edge++)
            {
                const qcClipPoint along = qcMinus(corner[(edge + 1) % 3], corner[edge]);
                ClipPolygon(corner[edge], qcCrossOf(along, {side * plane[0], side * plane[1], side * plane[2]}),
                            &polygon);
            }
            for (size_t i = 2; i < polygon.size(); i++)
                area.Add(polygon[0], polygon[i - 1], polygon[i]);
        }
    }
    return area;
}

/// `lowNormal`: the vector area of the whole lower face.
void AddBond(const CutFace& low, const CutFace& high, const qcClipPoint& lowNormal, const Area& area,
             const qcFractureUnits& units, double rounding, std::vector<qcBond>* bonds)
{
    if (area.IsThin(rounding))
        return;
    qcBond bond;
    bond.pieceA = low.piece;
    bond.pieceB = high.piece;
    bond.area = area.area * units.length * units.length;
    bond.center = units.Global({area.first[0] / area.area, area.first[1] / area.area, area.first[2] / area.area});
    qcClipPoint normal = lowNormal;
    if (qcDotOf(normal, normal) < s_minArea * s_minArea)
        normal = PlaneNormal(low);
    double length = std::max(std::sqrt(qcDotOf(normal, normal)), std::numeric_limits<double>::min());
    bond.normal = btVector3(btScalar(normal[0] / length), btScalar(normal[1] / length), btScalar(normal[2] / length));
    bonds->push_back(bond);
}

double SumOfAreas(const CutFace* begin, const CutFace* end)
{
    double sum = 0;
    for (const CutFace* face = begin; face != end; face++)
        sum += AreaOf(*face).area;
    return sum;
}

/// True if one of two sides of a cut has one face, and the other side's have its area together: they belong to it.
/// Splinters have been dropped where they have not.
bool IsShared(const CutFace* begin, const CutFace* middle, const CutFace* end)
{
    const double low = SumOfAreas(begin, middle), high = SumOfAreas(middle, end);
    return (middle - begin == 1 || end - middle == 1) && std::abs(low - high) <= s_sameArea * std::max(low, high);
}

/// The bonds in one cut: the faces from `begin` to `middle` are on its lower side, those up to `end` on the other.
void AddBonds(const CutFace* begin, const CutFace* middle, const CutFace* end, const qcFractureUnits& units,
              double rounding, std::vector<qcBond>* bonds)
{
    const bool isShared = IsShared(begin, middle, end), takesLow = end - middle == 1;
    for (const CutFace* low = begin; low != middle; low++)
    {
        const Area whole = AreaOf(*low);
        for (const CutFace* high = middle; high != end; high++)
        {
            const Area area = !isShared ? Overlap(*low, *high, rounding) : takesLow ? whole : AreaOf(*high);
            AddBond(*low, *high, whole.normal, area, units, rounding, bonds);
        }
    }
}

std::vector<CutFace> FindFaces(const std::vector<qcPieceCuts>& pieces)
{
    std::vector<CutFace> faces;
    for (uint32_t piece = 0; piece < pieces.size(); piece++)
    {
        std::vector<const qcCutTriangle*> sorted;
        for (const qcCutTriangle& triangle : pieces[piece].triangles)
            sorted.push_back(&triangle);
        std::stable_sort(sorted.begin(), sorted.end(),
                         [](const qcCutTriangle* a, const qcCutTriangle* b) { return a->otherCell < b->otherCell; });
        for (size_t i = 0; i < sorted.size(); i++)
        {
            uint32_t cell = pieces[piece].cell, other = sorted[i]->otherCell;
            if (i == 0 || other != sorted[i - 1]->otherCell)
                faces.push_back({std::min(cell, other), std::max(cell, other), cell > other, piece, {}});
            faces.back().triangles.push_back(sorted[i]->corner);
        }
    }
    auto key = [](const CutFace& face) { return std::tie(face.lowCell, face.highCell, face.isHigh, face.piece); };
    std::sort(faces.begin(), faces.end(), [&](const CutFace& a, const CutFace& b) { return key(a) < key(b); });
    return faces;
}
} // namespace

std::vector<qcBond> qcFindBonds(const std::vector<qcPieceCuts>& pieces, const qcFractureUnits& units, double rounding)
{
    std::vector<CutFace> faces = FindFaces(pieces);
    rounding = std::max(rounding, s_minRounding);
    std::vector<qcBond> bonds;
    for (const CutFace *begin = faces.data(), *last = begin + faces.size(); begin != last;)
    {
        const CutFace* end = std::find_if(
            begin, last,
            [&](const CutFace& face) { return face.lowCell != begin->lowCell || face.highCell != begin->highCell; });
        const CutFace* middle = std::find_if(begin, end, [](const CutFace& face) { return face.isHigh; });
        AddBonds(begin, middle, end, units, rounding, &bonds);
        begin = end;
    }
    std::sort(bonds.begin(), bonds.end(),
              [](const qcBond& a, const qcBond& b)
              { return std::tie(a.pieceA, a.pieceB) < std::tie(b.pieceA, b.pieceB); });
    return bonds;
}
