// Voronoi cells by voro++ (Rycroft: Voro++: a three-dimensional Voronoi cell library in C++, 2009), which gives the
// neighbours and corners of each. To distribute the solid, the cells are halved recursively, as in a k-d tree (Bentley:
// Multidimensional binary search trees used for associative searching, 1975), and the solid is clipped to each half's
// box.
#include "fracture/voronoi_cells.h"

#include "fracture/parallel_scratch.h"

#include "quickcullide/base.h"

#include <voro++/voro++.hh>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace
{
// voro++ treats squares of lengths that differ by less than 1e-11 as equal. Its input is scaled to a length of 4 to 8:
// rounding errors stay a hundred times below that tolerance.
constexpr int s_voroExponent = 3;
constexpr double s_maxSpread = 64; ///< max length of the walls, in units
// Min distance of two sites relative to the longest side of the walls. voro++ treats bisectors at a distance of 1e-7 as
// equal; those of closer sites come near that.
constexpr double s_minDistance = 1e-6;

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

void Enlarge(double by, Box* box)
{
    for (size_t i = 0; i < 3; i++)
    {
        box->lower[i] -= by;
        box->upper[i] += by;
    }
}

/// The enlarged AABB of the mesh and the sites.
Box FindWalls(const std::vector<qcClipPoint>& mesh, const std::vector<qcClipPoint>& sites)
{
    Box walls = {sites[0], sites[0]};
    for (const std::vector<qcClipPoint>* points : {&mesh, &sites})
        for (const qcClipPoint& p : *points)
            walls.Add(p, p);
    Enlarge(LengthOf(walls) / 16, &walls);
    return walls;
}

/// True if two sites are within this distance along each axis; it may be true up to twice the distance. In one of eight
/// shifted grids of twice that width, close sites are in the same cell.
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

/// Copies a cell of voro++. `scale`: from the mesh's units to those of voro++.
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
    // Far above the rounding errors of voro++, and small enough not to matter.
    Enlarge(LengthOf(walls) / 1024, &box);
    cell.lower = box.lower;
    cell.upper = box.upper;
    return cell;
}

/// Computes one of `batches` batches of the cells.
void FindCells(const Box& walls, const std::vector<qcClipPoint>& sites, size_t batch, size_t batches,
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
        if (i++ * batches / sites.size() == batch && container.compute_cell(found, loop))
            (*cells)[site] = CellOf(&found, walls, sites, site, scale);
    } while (loop.inc());
}

//  ---- distribution ----------------------------------------------------------------------------------

/// Some of the cells, and the solid clipped to their box.
struct Portion
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

/// Clips a solid by those sides of the box that remove more than a quarter of its points.
void ClipToBox(const qcClipSolid& from, const Box& box, uint32_t firstFace, qcClipScratch* scratch, qcClipSolid* to)
{
    const qcClipSolid* solid = &from;
    for (size_t side = 0; side < 6; side++)
    {
        size_t axis = side / 2;
        double sign = side % 2 == 0 ? 1 : -1;
        qcClipPlane plane = {{0, 0, 0}, sign > 0 ? box.upper[axis] : -box.lower[axis], firstFace + uint32_t(side)};
        plane.normal[axis] = sign;
        auto isOutside = [&](const qcClipPoint& p) { return sign * p[axis] > plane.distance; };
        size_t outside = size_t(std::count_if(solid->points.begin(), solid->points.end(), isOutside));
        if (4 * outside > solid->points.size()) // 2, 8 and 16 take equally many instructions, within 1 % (bunny)
        {
            qcClipSolid_Clip(*solid, plane, scratch, to);
            solid = to;
        }
    }
    if (solid == &from)
        *to = from;
}

/// Halves the cells at the median of their centres, along the longest axis of these.
std::array<std::vector<size_t>, 2> Halve(const std::vector<qcFractureCell>& cells, std::vector<size_t> some)
{
    auto centre = [&](size_t cell, size_t axis) { return cells[cell].lower[axis] + cells[cell].upper[axis]; };
    size_t longest = qcLongestAxis(some, centre);
    auto middle = some.begin() + std::ptrdiff_t(some.size() / 2);
    std::nth_element(some.begin(), middle, some.end(),
                     [&](size_t a, size_t b)
                     { return std::make_pair(centre(a, longest), a) < std::make_pair(centre(b, longest), b); });
    return {std::vector<size_t>(some.begin(), middle), std::vector<size_t>(middle, some.end())};
}

struct Distribution
{
    const std::vector<qcFractureCell>& cells;
    uint32_t firstFace;
    const std::function<void(size_t cell, const qcClipSolid& solid, qcClipScratch* scratch)>& take;

    /// The first or the second half of a portion. A portion of one cell is its own second half.
    Portion Half(const Portion& portion, size_t which, qcClipScratch* scratch) const
    {
        if (portion.cells.size() == 1)
            return which == 0 ? Portion() : portion;
        Portion half;
        half.cells = Halve(cells, portion.cells)[which];
        ClipToBox(portion.solid, BoxOf(cells, half.cells), firstFace, scratch, &half.solid);
        return half;
    }

    /// Halves some cells and their solid down to single cells, depth first: little memory is in use at once.
    void Descend(const std::vector<size_t>& some, const qcClipSolid& solid, qcClipScratch* scratch) const
    {
        if (some.size() == 1)
        {
            take(some[0], solid, scratch);
            return;
        }
        qcClipSolid half;
        for (const std::vector<size_t>& part : Halve(cells, some))
        {
            ClipToBox(solid, BoxOf(cells, part), firstFace, scratch, &half);
            Descend(part, half, scratch);
        }
    }
};
} // namespace

std::vector<qcFractureCell> qcFindFractureCells(const std::vector<qcClipPoint>& mesh,
                                                const std::vector<qcClipPoint>& sites)
{
    // Each batch of cells needs a container of all sites.
    constexpr size_t minBatch = 16, maxBatches = 64, batchesOfWorker = 4;
    Box walls = FindWalls(mesh, sites);
    if (LengthOf(walls) > s_maxSpread || AreAnyClose(sites, s_minDistance * LengthOf(walls)))
        return {};
    std::vector<qcFractureCell> cells(sites.size(), {{}, walls.lower, walls.upper});
    size_t workers = qcGetWorkerCount();
    size_t batches = std::min({maxBatches, 1 + sites.size() / minBatch, workers > 1 ? batchesOfWorker * workers : 1});
    qcForEachInParallel(batches,
                        [&](size_t batch, qcClipScratch*) { FindCells(walls, sites, batch, batches, &cells); });
    return cells;
}

void qcDistributeSolid(qcClipSolid solid, const std::vector<qcFractureCell>& cells, uint32_t firstFace,
                       const std::function<void(size_t cell, const qcClipSolid& solid, qcClipScratch* scratch)>& take)
{
    constexpr size_t portionsOfWorker = 8;
    size_t workers = qcGetWorkerCount();
    size_t enough = std::min(workers > 1 ? portionsOfWorker * workers : 1, cells.size());
    Distribution distribution = {cells, firstFace, take};
    std::vector<Portion> portions(1);
    portions[0].cells.resize(cells.size());
    std::iota(portions[0].cells.begin(), portions[0].cells.end(), size_t(0));
    portions[0].solid = std::move(solid);
    while (portions.size() < enough)
    {
        std::vector<Portion> halves(2 * portions.size());
        qcForEachInParallel(halves.size(), [&](size_t i, qcClipScratch* scratch)
                            { halves[i] = distribution.Half(portions[i / 2], i % 2, scratch); });
        halves.erase(
            std::remove_if(halves.begin(), halves.end(), [](const Portion& portion) { return portion.cells.empty(); }),
            halves.end());
        portions = std::move(halves);
    }
    qcForEachInParallel(portions.size(), [&](size_t i, qcClipScratch* scratch)
                        { distribution.Descend(portions[i].cells, portions[i].solid, scratch); });
}
