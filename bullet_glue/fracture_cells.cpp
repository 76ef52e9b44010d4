// Voronoi cells by voro++ (Rycroft: Voro++: a three-dimensional Voronoi cell library in C++, 2009), which tells the
// neighbours of each and where it is. Cells are halved again and again, as in a k-d tree (Bentley: Multidimensional
// binary search trees used for associative searching, 1975), and the solid is cut along the box of each half.
#include "fracture_cells.h"

#include <voro++/voro++.hh>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <future>
#include <numeric>
#include <thread>

namespace
{
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

/// The box of everything, with room around it.
Box FindWalls(const qcClipMesh& mesh, const std::vector<qcClipPoint>& sites)
{
    Box walls = {sites[0], sites[0]};
    for (const std::vector<qcClipPoint>* points : {&mesh.points, &sites})
        for (const qcClipPoint& p : *points)
            walls.Add(p, p);
    for (size_t i = 0; i < 3; i++)
    {
        double room = (walls.upper[i] - walls.lower[i]) / 16 + 1e-30;
        walls.lower[i] -= room;
        walls.upper[i] += room;
    }
    return walls;
}

//  ---- cells -----------------------------------------------------------------------------------------

qcFractureCell CellOf(voro::voronoicell_neighbor* found, const Box& walls, const std::vector<qcClipPoint>& sites,
                      size_t site)
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
    found->vertices(sites[site][0], sites[site][1], sites[site][2], corners);
    Box box = {sites[site], sites[site]};
    for (size_t i = 0; i + 2 < corners.size(); i += 3)
        box.Add({corners[i], corners[i + 1], corners[i + 2]}, {corners[i], corners[i + 1], corners[i + 2]});
    for (size_t axis = 0; axis < 3; axis++)
    {
        // Far above what voro++ rounds off, and too little to matter.
        double room = (walls.upper[axis] - walls.lower[axis]) / 1024;
        cell.lower[axis] = box.lower[axis] - room;
        cell.upper[axis] = box.upper[axis] + room;
    }
    return cell;
}

/// One share of the cells.
void FindCells(const Box& walls, const std::vector<qcClipPoint>& sites, size_t share, size_t shares,
               std::vector<qcFractureCell>* cells)
{
    const qcClipPoint &lower = walls.lower, &upper = walls.upper;
    // About five sites a block, as the manual advises.
    int blocks = std::max(1, int(std::cbrt(double(sites.size()) / 5)));
    voro::container container(lower[0], upper[0], lower[1], upper[1], lower[2], upper[2], blocks, blocks, blocks, false,
                              false, false, 8);
    for (size_t i = 0; i < sites.size(); i++)
        container.put(int(i), sites[i][0], sites[i][1], sites[i][2]);
    voro::voronoicell_neighbor found;
    voro::c_loop_all loop(container);
    if (!loop.start())
        return;
    size_t i = 0;
    do
    {
        size_t site = size_t(loop.pid());
        if (i++ * shares / sites.size() == share && container.compute_cell(found, loop))
            (*cells)[site] = CellOf(&found, walls, sites, site);
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

/// Calls the function for each index below `count`, on all cores, with scratch. What it throws is thrown here.
template <typename Function> void ForEach(size_t count, Function function)
{
    std::atomic<size_t> next{0};
    auto work = [&]
    {
        qcClipScratch scratch;
        for (size_t i = next++; i < count; i = next++)
            function(i, &scratch);
    };
    std::vector<std::future<void>> others;
    for (size_t k = 1; k < std::min(count, size_t(std::thread::hardware_concurrency())); k++)
        others.push_back(std::async(std::launch::async, work));
    work();
    for (std::future<void>& other : others)
        other.get();
}
} // namespace

std::vector<qcFractureCell> qcFindFractureCells(const qcClipMesh& mesh, const std::vector<qcClipPoint>& sites)
{
    constexpr size_t leastShare = 16, mostShares = 64; // of cells: each needs a container of all sites
    Box walls = FindWalls(mesh, sites);
    std::vector<qcFractureCell> cells(sites.size(), {{}, walls.lower, walls.upper});
    size_t shares = std::min(mostShares, 1 + sites.size() / leastShare);
    ForEach(shares, [&](size_t share, qcClipScratch*) { FindCells(walls, sites, share, shares, &cells); });
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
        ForEach(halves.size(),
                [&](size_t i, qcClipScratch* scratch)
                {
                    const Share& share = shares[i / 2];
                    if (share.cells.size() == 1 && i % 2 == 0)
                        take(share.cells[0], share.solid, scratch);
                    if (share.cells.size() == 1)
                        return;
                    halves[i].cells = std::move(Halve(cells, share.cells)[i % 2]);
                    halves[i].solid = share.solid;
                    CutAround(BoxOf(cells, halves[i].cells), firstFace, &halves[i].solid, scratch);
                });
        halves.erase(
            std::remove_if(halves.begin(), halves.end(), [](const Share& share) { return share.cells.empty(); }),
            halves.end());
        shares = std::move(halves);
    }
}
