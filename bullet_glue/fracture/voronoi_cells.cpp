// Voronoi cells by voro++ (Rycroft: Voro++: a three-dimensional Voronoi cell library in C++, 2009), which gives the
// neighbours and corners of each. Cells are halved again and again, as in a k-d tree (Bentley: Multidimensional
// binary search trees used for associative searching, 1975), and the solid is cut along the box of each half.
#include "fracture/voronoi_cells.h"

#include "fracture/parallel_cells.h"

#include <voro++/voro++.hh>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace
{
// voro++ takes squares of lengths that differ by less than 1e-11 as equal. What is given to it is 4 to 8 long: its
// rounding errors stay a hundred times below that.
constexpr int s_voroExponent = 3;
constexpr double s_greatestSpread = 64; ///< of sites around a mesh, in units
// Of the longest side of the walls. Two sites this close: voro++ takes bisectors as equal that are 1e-7 apart.
constexpr double s_leastDistance = 1e-6;

struct Box
{
    qcClipPoint lower, upper;

    void Add(const qcClipPoint& low, const qcClipPoint& high)
    {
        for (size_t i = 0; i < 3; i++)
        {
            lower[i] = std::min(lower[i], low[i]);
            upper[i] = std::max(upper[i], high[i]);
        }
    }
};

/// The longest side.
double LengthOf(const Box& box)
{
    return std::max({box.upper[0] - box.lower[0], box.upper[1] - box.lower[1], box.upper[2] - box.lower[2]});
}

void AddRoom(double room, Box* box)
{
    for (size_t i = 0; i < 3; i++)
    {
        box->lower[i] -= room;
        box->upper[i] += room;
    }
}

/// The box of the mesh and the sites, with room around it.
Box FindWalls(const std::vector<qcClipPoint>& mesh, const std::vector<qcClipPoint>& sites)
{
    Box walls = {sites[0], sites[0]};
    for (const std::vector<qcClipPoint>* points : {&mesh, &sites})
        for (const qcClipPoint& p : *points)
            walls.Add(p, p);
    AddRoom(LengthOf(walls) / 16, &walls);
    return walls;
}

/// Whether two sites are no further apart than this along each axis. Some that are up to twice as far apart count, too:
/// in one of eight shifted grids of twice that width, close sites are in the same cell.
bool AreAnyClose(const std::vector<qcClipPoint>& sites, double distance)
{
    qcHashTable<qcClipPoint, uint32_t> grid;
    for (int shift = 0; shift < 8; shift++)
    {
        grid.Clear(sites.size());
        for (uint32_t i = 0; i < sites.size(); i++)
        {
            qcClipPoint key;
            for (size_t axis = 0; axis < 3; axis++)
                key[axis] = std::floor(sites[i][axis] / (2 * distance) + (shift >> axis & 1) * 0.5);
            if (grid.FindOrAdd(key, i) != i)
                return true;
        }
    }
    return false;
}

//  ---- cells -----------------------------------------------------------------------------------------

/// `scale`: from units to those of voro++.
qcFractureCell CellOf(voro::voronoicell_neighbor* found, const Box& walls, const std::vector<qcClipPoint>& sites,
                      size_t site, double scale)
{
    qcFractureCell cell;
    std::vector<int> neighbours;
    found->neighbors(neighbours);
    for (int other : neighbours)
        if (other >= 0) // the others are walls
            cell.neighbours.push_back(uint32_t(other));
    auto distance2 = [&](uint32_t other)
    {
        qcClipPoint d;
        for (size_t i = 0; i < 3; i++)
            d[i] = sites[other][i] - sites[site][i];
        return qcDotOf(d, d);
    };
    std::sort(cell.neighbours.begin(), cell.neighbours.end(),
              [&](uint32_t a, uint32_t b)
              { return std::make_pair(distance2(a), a) < std::make_pair(distance2(b), b); });
    std::vector<double> corners;
    found->vertices(0, 0, 0, corners);
    Box box = {sites[site], sites[site]};
    for (size_t i = 0; i + 2 < corners.size(); i += 3)
    {
        qcClipPoint corner;
        for (size_t axis = 0; axis < 3; axis++)
            corner[axis] = sites[site][axis] + corners[i + axis] / scale;
        box.Add(corner, corner);
    }
    // Far above the rounding errors of voro++, and too little to matter.
    AddRoom(LengthOf(walls) / 1024, &box);
    cell.lower = box.lower;
    cell.upper = box.upper;
    return cell;
}

/// One share of the cells.
void FindCells(const Box& walls, const std::vector<qcClipPoint>& sites, size_t share, size_t shares,
               std::vector<qcFractureCell>* cells)
{
    int exponent;
    std::frexp(LengthOf(walls), &exponent);
    double scale = std::ldexp(1, s_voroExponent - exponent);
    qcClipPoint lower = walls.lower, upper = walls.upper;
    for (size_t axis = 0; axis < 3; axis++)
    {
        lower[axis] *= scale;
        upper[axis] *= scale;
    }
    // About five sites a block, as the manual advises.
    int blocks = std::max(1, int(std::cbrt(double(sites.size()) / 5)));
    voro::container container(lower[0], upper[0], lower[1], upper[1], lower[2], upper[2], blocks, blocks, blocks, false,
                              false, false, 8);
    for (size_t i = 0; i < sites.size(); i++)
        container.put(int(i), scale * sites[i][0], scale * sites[i][1], scale * sites[i][2]);
    voro::voronoicell_neighbor found;
    voro::c_loop_all loop(container);
    if (!loop.start())
        return;
    size_t i = 0;
    do
    {
        size_t site = size_t(loop.pid());
        if (i++ * shares / sites.size() == share && container.compute_cell(found, loop))
            (*cells)[site] = CellOf(&found, walls, sites, site, scale);
    } while (loop.inc());
}

//  ---- dealing ---------------------------------------------------------------------------------------

/// Some of the cells, and what the solid is in their box.
struct Share
{
    std::vector<size_t> cells;
    qcClipSolid solid;
};

Box BoxOf(const std::vector<qcFractureCell>& cells, const std::vector<size_t>& some)
{
    Box box = {cells[some[0]].lower, cells[some[0]].upper};
    for (size_t cell : some)
        box.Add(cells[cell].lower, cells[cell].upper);
    return box;
}

/// Cuts off what is outside of the box, where that is enough to be worth a face.
void CutAround(const Box& box, uint32_t firstFace, qcClipSolid* solid, qcClipScratch* scratch)
{
    for (size_t side = 0; side < 6; side++)
    {
        size_t axis = side / 2;
        double sign = side % 2 == 0 ? 1 : -1;
        qcClipPlane plane = {{0, 0, 0}, sign > 0 ? box.upper[axis] : -box.lower[axis], firstFace + uint32_t(side)};
        plane.normal[axis] = sign;
        auto isOutside = [&](const qcClipPoint& p) { return sign * p[axis] > plane.distance; };
        size_t outside = size_t(std::count_if(solid->points.begin(), solid->points.end(), isOutside));
        if (4 * outside > solid->points.size()) // 2, 8 and 16 take as many instructions, within 1% (bunny)
            qcClipSolid_Cut(solid, plane, scratch);
    }
}

/// Halves the cells where their centres are furthest apart.
std::array<std::vector<size_t>, 2> Halve(const std::vector<qcFractureCell>& cells, std::vector<size_t> some)
{
    auto centre = [&](size_t cell, size_t axis) { return cells[cell].lower[axis] + cells[cell].upper[axis]; };
    size_t longest = 0;
    double most = -1;
    for (size_t axis = 0; axis < 3; axis++)
    {
        auto isLower = [&](size_t a, size_t b) { return centre(a, axis) < centre(b, axis); };
        auto ends = std::minmax_element(some.begin(), some.end(), isLower);
        double length = centre(*ends.second, axis) - centre(*ends.first, axis);
        if (length > most)
        {
            most = length;
            longest = axis;
        }
    }
    auto middle = some.begin() + std::ptrdiff_t(some.size() / 2);
    std::nth_element(some.begin(), middle, some.end(),
                     [&](size_t a, size_t b)
                     { return std::make_pair(centre(a, longest), a) < std::make_pair(centre(b, longest), b); });
    return {std::vector<size_t>(some.begin(), middle), std::vector<size_t>(middle, some.end())};
}
} // namespace

std::vector<qcFractureCell> qcFindFractureCells(const std::vector<qcClipPoint>& mesh,
                                                const std::vector<qcClipPoint>& sites)
{
    constexpr size_t leastShare = 16, mostShares = 64; // of cells: each needs a container of all sites
    Box walls = FindWalls(mesh, sites);
    if (LengthOf(walls) > s_greatestSpread || AreAnyClose(sites, s_leastDistance * LengthOf(walls)))
        return {};
    std::vector<qcFractureCell> cells(sites.size(), {{}, walls.lower, walls.upper});
    size_t shares = std::min(mostShares, 1 + sites.size() / leastShare);
    qcForEachInParallel(shares, [&](size_t share, qcClipScratch*) { FindCells(walls, sites, share, shares, &cells); });
    return cells;
}

void qcDealSolid(qcClipSolid solid, const std::vector<qcFractureCell>& cells, uint32_t firstFace,
                 const std::function<void(size_t cell, qcClipSolid solid, qcClipScratch* scratch)>& take)
{
    std::vector<Share> shares(1);
    shares[0].cells.resize(cells.size());
    std::iota(shares[0].cells.begin(), shares[0].cells.end(), size_t(0));
    shares[0].solid = std::move(solid);
    while (!shares.empty())
    {
        std::vector<Share> halves(2 * shares.size());
        auto halve = [&](size_t i, qcClipScratch* scratch)
        {
            const Share& share = shares[i / 2];
            if (share.cells.size() == 1 && i % 2 == 0)
                take(share.cells[0], share.solid, scratch);
            if (share.cells.size() == 1)
                return;
            halves[i].cells = std::move(Halve(cells, share.cells)[i % 2]);
            halves[i].solid = share.solid;
            CutAround(BoxOf(cells, halves[i].cells), firstFace, &halves[i].solid, scratch);
        };
        qcForEachInParallel(halves.size(), halve);
        halves.erase(
            std::remove_if(halves.begin(), halves.end(), [](const Share& share) { return share.cells.empty(); }),
            halves.end());
        shares = std::move(halves);
    }
}
