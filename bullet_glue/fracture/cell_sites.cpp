// Sites in the units of a mesh. Sums that cancel are exact: expansions after Shewchuk, Adaptive precision
// floating-point arithmetic and fast robust geometric predicates, 1997. Compiled without contraction to fused
// multiply-adds, which would make them inexact.
#include "fracture/cell_sites.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace
{
// Squares of distances, and sums of a few of them, stay finite.
const double s_maxDistance = std::ldexp(1, 480);

double LengthOf(const qcClipPoint& v)
{
    double longest = std::max({std::fabs(v[0]), std::fabs(v[1]), std::fabs(v[2])});
    if (longest == 0 || std::isinf(longest))
        return longest;
    qcClipPoint u = {v[0] / longest, v[1] / longest, v[2] / longest};
    return longest * std::sqrt(qcDotOf(u, u));
}

/// An exact sum of products: a non-overlapping expansion, smallest component first.
class ExactSum
{
  public:
    void AddProduct(double a, double b)
    {
        double product = a * b;
        Add(std::fma(a, b, -product));
        Add(product);
    }

    double Rounded() const
    {
        double sum = 0;
        for (size_t i = 0; i < m_count; i++)
            sum += m_components[i];
        return sum;
    }

  private:
    void Add(double x)
    {
        size_t kept = 0;
        for (size_t i = 0; i < m_count; i++)
        {
            double component = m_components[i], sum = x + component, virtualComponent = sum - x;
            double rest = (x - (sum - virtualComponent)) + (component - virtualComponent);
            if (rest != 0)
                m_components[kept++] = rest;
            x = sum;
        }
        if (x != 0)
            m_components[kept++] = x;
        m_count = kept;
    }

    std::array<double, 24> m_components; ///< of at most twelve products
    size_t m_count = 0;
};

/// |b - origin|^2 - |a - origin|^2, an exact sum that is rounded at its end. Exchanging a and b exactly negates it.
double DifferenceOfSquares(const qcClipPoint& a, const qcClipPoint& b, const qcClipPoint& origin)
{
    ExactSum sum;
    for (size_t i = 0; i < 3; i++)
    {
        sum.AddProduct(b[i], b[i]);
        sum.AddProduct(-a[i], a[i]);
        if (origin[i] != 0)
        {
            sum.AddProduct(-2 * origin[i], b[i]);
            sum.AddProduct(2 * origin[i], a[i]);
        }
    }
    return sum.Rounded();
}
} // namespace

std::string qcFractureSites_Find(const qcFractureDef& def, const qcFractureUnits& units, const qcFacetedMesh& mesh,
                                 qcFractureSites* sites)
{
    qcClipPoint lower = mesh.points[0], upper = lower;
    for (const qcClipPoint& p : mesh.points)
        for (size_t i = 0; i < 3; i++)
        {
            lower[i] = std::min(lower[i], p[i]);
            upper[i] = std::max(upper[i], p[i]);
        }
    qcClipPoint centre = {(lower[0] + upper[0]) / 2, (lower[1] + upper[1]) / 2, (lower[2] + upper[2]) / 2};
    std::vector<double> distances;
    for (const btVector3& site : def.sites)
        distances.push_back(LengthOf(qcMinus(units.Local(site), centre)));
    size_t nearest = size_t(std::min_element(distances.begin(), distances.end()) - distances.begin());
    if (!(distances[nearest] < s_maxDistance))
        return "site " + std::to_string(nearest) + ", the nearest, is more than " + qcTextOf(s_maxDistance) +
               " times as far from the mesh as the mesh is long";
    // Every point of the mesh is nearer to the nearest site than to a site further away than this.
    double maxDistance = distances[nearest] * (1 + 1e-9) + LengthOf(qcMinus(upper, lower));
    for (size_t i = 0; i < def.sites.size(); i++)
        if (distances[i] <= maxDistance)
        {
            sites->numbers.push_back(uint32_t(i));
            sites->scaled.push_back(units.Scaled(def.sites[i]));
            sites->local.push_back(units.Local(def.sites[i]));
        }
    sites->origin = units.origin;
    if (auto equal = qcFindEqual(sites->scaled))
        return "sites " + std::to_string(sites->numbers[equal->first]) + " and " +
               std::to_string(sites->numbers[equal->second]) +
               " are at the same place: in units of the mesh's length, " + qcTextOf(units.length) +
               ", their distance is below the range of double";
    return "";
}

std::optional<std::pair<size_t, size_t>> qcFindEqual(const std::vector<qcClipPoint>& points)
{
    std::vector<std::pair<qcClipPoint, size_t>> sorted;
    for (size_t i = 0; i < points.size(); i++)
        sorted.emplace_back(points[i], i);
    std::sort(sorted.begin(), sorted.end());
    for (size_t i = 1; i < sorted.size(); i++)
        if (sorted[i].first == sorted[i - 1].first)
            return std::make_pair(sorted[i - 1].second, sorted[i].second);
    return std::nullopt;
}

qcClipPlane qcFractureSites_Bisect(const qcFractureSites& sites, uint32_t site, uint32_t other, uint32_t face)
{
    const qcClipPoint &a = sites.scaled[site], &b = sites.scaled[other];
    if (b < a)
    {
        qcClipPlane mirrored = qcFractureSites_Bisect(sites, other, site, face);
        const qcClipPoint& n = mirrored.normal;
        return {{-n[0], -n[1], -n[2]}, -mirrored.distance, face};
    }
    qcClipPoint across = qcMinus(b, a);
    double length = LengthOf(across);
    return {{across[0] / length, across[1] / length, across[2] / length},
            DifferenceOfSquares(a, b, sites.origin) / 2 / length,
            face};
}

void qcFractureSites_ClipCell(const qcFractureSites& sites, uint32_t site, uint32_t firstFace,
                              const qcRoundedFaces* rounded, qcClipSolid* solid, qcClipScratch* scratch)
{
    std::vector<std::pair<double, uint32_t>> others;
    for (uint32_t other = 0; other < sites.scaled.size(); other++)
        if (other != site)
            others.emplace_back(LengthOf(qcMinus(sites.scaled[other], sites.scaled[site])), other);
    // A heap, since only the nearest few are used.
    auto isFurther = std::greater<std::pair<double, uint32_t>>();
    std::make_heap(others.begin(), others.end(), isFurther);
    while (!others.empty())
    {
        double radius = 0;
        for (const qcClipPoint& p : solid->points)
            radius = std::max(radius, LengthOf(qcMinus(p, sites.local[site])));
        auto [distance, other] = others.front();
        // Every remaining point is nearer to this site.
        if (distance > 2 * radius * (1 + 1e-9))
            return;
        qcClipPlane plane = qcFractureSites_Bisect(sites, site, other, firstFace + other);
        plane.rounded = rounded;
        qcClipSolid_Clip(*solid, plane, scratch, solid);
        std::pop_heap(others.begin(), others.end(), isFurther);
        others.pop_back();
    }
}
