// Sites in the units of a mesh. Products and sums that cancel are exact: expansions after Shewchuk (Adaptive precision
// floating-point arithmetic and fast robust geometric predicates, 1997). Compiled without contraction to fused
// multiply-adds, which would break them.
#include "fracture/cell_sites.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace
{
// Squares of distances stay finite, sums of some included.
const double s_mostDistance = std::ldexp(1, 480);

double LengthOf(const qcClipPoint& v)
{
    double most = std::max({std::fabs(v[0]), std::fabs(v[1]), std::fabs(v[2])});
    if (most == 0 || std::isinf(most))
        return most;
    qcClipPoint u = {v[0] / most, v[1] / most, v[2] / most};
    return most * std::sqrt(qcDotOf(u, u));
}

qcClipPoint Minus(const qcClipPoint& a, const qcClipPoint& b)
{
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

/// An exact sum of products, as parts that don't overlap, smallest first.
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
            sum += m_parts[i];
        return sum;
    }

  private:
    void Add(double x)
    {
        size_t kept = 0;
        for (size_t i = 0; i < m_count; i++)
        {
            double part = m_parts[i], sum = x + part, virtualPart = sum - x;
            double rest = (x - (sum - virtualPart)) + (part - virtualPart);
            if (rest != 0)
                m_parts[kept++] = rest;
            x = sum;
        }
        if (x != 0)
            m_parts[kept++] = x;
        m_count = kept;
    }

    std::array<double, 24> m_parts; ///< of twelve products at most
    size_t m_count = 0;
};

/// |b - origin|^2 - |a - origin|^2, rounded once.
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

std::string qcFractureSites_Find(const qcFractureDef& def, const qcFractureUnits& units, const qcClipMesh& mesh,
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
        distances.push_back(LengthOf(Minus(units.Local(site), centre)));
    size_t nearest = size_t(std::min_element(distances.begin(), distances.end()) - distances.begin());
    if (!(distances[nearest] < s_mostDistance))
        return "site " + std::to_string(nearest) + ", the nearest, is more than " + qcTextOf(s_mostDistance) +
               " times as far from the mesh as the mesh is long";
    // Each point of the mesh is nearer to the nearest site than to one that is further away than this.
    double reach = distances[nearest] * (1 + 1e-9) + LengthOf(Minus(upper, lower));
    for (size_t i = 0; i < def.sites.size(); i++)
        if (distances[i] <= reach)
        {
            sites->numbers.push_back(uint32_t(i));
            sites->scaled.push_back(units.Scaled(def.sites[i]));
            sites->local.push_back(units.Local(def.sites[i]));
        }
    sites->origin = units.origin;
    return "";
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
    qcClipPoint across = Minus(b, a);
    double length = LengthOf(across);
    return {{across[0] / length, across[1] / length, across[2] / length},
            DifferenceOfSquares(a, b, sites.origin) / 2 / length,
            face};
}

void qcFractureSites_CutCell(const qcFractureSites& sites, uint32_t site, uint32_t firstFace, qcClipSolid* solid,
                             qcClipScratch* scratch)
{
    std::vector<std::pair<double, uint32_t>> others;
    for (uint32_t other = 0; other < sites.scaled.size(); other++)
        if (other != site)
            others.emplace_back(LengthOf(Minus(sites.scaled[other], sites.scaled[site])), other);
    // A heap: only the nearest few are sorted.
    auto isFurther = std::greater<std::pair<double, uint32_t>>();
    std::make_heap(others.begin(), others.end(), isFurther);
    while (!others.empty())
    {
        double radius = 0;
        for (const qcClipPoint& p : solid->points)
            radius = std::max(radius, LengthOf(Minus(p, sites.local[site])));
        auto [distance, other] = others.front();
        // All that is left is nearer to this site.
        if (distance > 2 * radius * (1 + 1e-9))
            return;
        qcClipSolid_Cut(solid, qcFractureSites_Bisect(sites, site, other, firstFace + other), scratch);
        std::pop_heap(others.begin(), others.end(), isFurther);
        others.pop_back();
    }
}
