// Compares each tested triangle with the renders before it. Several invocations share a triangle.
const uint lanes = 8u;
shared uint found[8]; // by triangle of the workgroup

// Whether a triangle surely covers a point.
bool covers(Triangle t, vec2 point)
{
    for (int i = 0; i < 3; i++)
    {
        int k = i < 2 ? i + 1 : 0;
        float error, side = t.plane.z * cross2(vec2(t.x[k] - t.x[i], t.y[k] - t.y[i]),
                                               point - vec2(t.x[i], t.y[i]), error);
        if (!(side > error))
            return false;
    }
    return true;
}

float depthAt(Triangle t, vec2 point)
{
    return t.z.x + t.plane.x * (point.x - t.x.x) + t.plane.y * (point.y - t.y.x);
}

bool isCorner(Triangle t, vec2 point)
{
    return (t.x.x == point.x && t.y.x == point.y) || (t.x.y == point.x && t.y.y == point.y) ||
           (t.x.z == point.x && t.y.z == point.y);
}

// Whether an edge of `a` has `b` beyond it: corners that both have stay on the edge however they are rounded.
bool separatesByEdge(Triangle a, Triangle b)
{
    for (int i = 0; a.plane.z != 0.0 && i < 3; i++)
    {
        int k = i < 2 ? i + 1 : 0;
        vec2 from = vec2(a.x[i], a.y[i]), to = vec2(a.x[k], a.y[k]);
        bool isBeyond = true;
        for (int c = 0; c < 3 && isBeyond; c++)
        {
            vec2 point = vec2(b.x[c], b.y[c]);
            float error, side = a.plane.z * cross2(to - from, point - from, error);
            isBeyond = point == from || point == to || side < -error;
        }
        if (isBeyond)
            return true;
    }
    return false;
}

// Whether a line through a corner that both have separates the rest of them.
bool separatesByCorner(Triangle a, Triangle b)
{
    int i = 0;
    while (i < 3 && !isCorner(b, vec2(a.x[i], a.y[i])))
        i++;
    if (i == 3)
        return false;
    vec2 corner = vec2(a.x[i], a.y[i]);
    vec2 n = vec2(a.x.x + a.x.y + a.x.z - b.x.x - b.x.y - b.x.z, a.y.x + a.y.y + a.y.z - b.y.x - b.y.y - b.y.z);
    float margin = 3.0 * snap * (abs(n.x) + abs(n.y));
    for (int k = 0; k < 3; k++)
    {
        vec2 p = vec2(a.x[k], a.y[k]), q = vec2(b.x[k], b.y[k]);
        if (p != corner && !(dot(p - corner, n) > margin))
            return false;
        if (q != corner && !(dot(q - corner, n) < -margin))
            return false;
    }
    return true;
}

// Whether the corners of `corners` are all farther (side 1) or nearer (-1) than the plane of `plane`, by their errors.
bool isBeyondPlane(Triangle corners, Triangle plane, float side)
{
    float slack = corners.z.w + plane.z.w;
    for (int i = 0; i < 3; i++)
        if (!((corners.z[i] - depthAt(plane, vec2(corners.x[i], corners.y[i]))) * side > slack))
            return false;
    return true;
}

// Whether a render may hide a test in some sample.
bool mayHide(Triangle render, Triangle test)
{
    if (render.plane.z != 0.0 && test.plane.z != 0.0 &&
        (isBeyondPlane(render, test, 1.0) || isBeyondPlane(test, render, -1.0)))
        return false;
    return !separatesByEdge(test, render) && !separatesByEdge(render, test) && !separatesByCorner(test, render);
}

uint cellFirst(uint cell)
{
    return cells[cellsPerSide * cellsPerSide + cell];
}

uint cellEnd(uint cell)
{
    return min(cells[cell], entryCapacity);
}

// Some implementations stop the loops of an invocation after 65 535 iterations in all.
void checkEnd(uint at, uint end)
{
    if (at < end)
        results[stopCounter] = 1u;
}

// Whether the sample nearest to a point of a triangle is surely hidden by renders of steps before its own: every
// `stride`-th of them.
bool isSampleHidden(Triangle t, uint step, vec2 point, uint first, uint stride)
{
    vec2 center = floor(point) + 0.5;
    if (!covers(t, center))
        return false;
    float depth = depthAt(t, center) - t.z.w;
    uint cell = findCell(center.y) * cellsPerSide + findCell(center.x), at = cellFirst(cell) + first,
         end = cellEnd(cell);
    for (; at < end; at += stride)
    {
        Entry entry = entries[at];
        if (entry.step >= step || entry.nearest > depth || any(greaterThan(entry.box.xy, center)) ||
            any(lessThan(entry.box.zw, center)))
            continue;
        Triangle render = triangles[entry.part];
        if (render.plane.z != 0.0 && depthAt(render, center) + render.z.w < depth && covers(render, center))
            return true;
    }
    checkEnd(at, end);
    return false;
}

// Whether some sample of a triangle is surely hidden: near the centre and near the corners, a sample for two lanes.
bool isHidden(Triangle t, uint step, uint lane)
{
    vec2 centre = vec2(t.x.x + t.x.y + t.x.z, t.y.x + t.y.y + t.y.z) / 3.0;
    uint corner = lane & 3u;
    vec2 point = corner == 3u ? centre : 0.25 * centre + 0.75 * vec2(t.x[corner], t.y[corner]);
    return t.plane.z != 0.0 && isSampleHidden(t, step, point, lane >> 2, lanes >> 2);
}

// Marks the renders in a cell that may hide a triangle, every `lanes`-th of them. Returns whether there are any.
bool markCell(Triangle t, uint step, uvec2 cellAt, uint lane)
{
    bool marked = false;
    uint cell = cellAt.y * cellsPerSide + cellAt.x, at = cellFirst(cell) + lane, end = cellEnd(cell);
    for (; at < end; at += lanes)
    {
        Entry entry = entries[at];
        if (entry.step >= step || entry.nearest > t.y.w || any(greaterThan(entry.box.xy, t.box.zw)) ||
            any(lessThan(entry.box.zw, t.box.xy)))
            continue;
        // Only in the first cell that both are in.
        vec2 first = max(entry.box.xy, t.box.xy);
        if (uvec2(findCell(first.x), findCell(first.y)) != cellAt || !mayHide(triangles[entry.part], t))
            continue;
        atomicOr(results[firstResult + entry.part], usesRender);
        marked = true;
    }
    checkEnd(at, end);
    return marked;
}

// Marks the renders that may hide a triangle. Returns whether there are any.
bool markHiders(Triangle t, uint step, uint lane)
{
    bool marked = false;
    uvec4 range = findCells(t.box);
    uint y = range.y, x;
    for (; y <= range.w; y++)
    {
        for (x = range.x; x <= range.z; x++)
            marked = markCell(t, step, uvec2(x, y), lane) || marked;
        checkEnd(x, range.z + 1u);
    }
    checkEnd(y, range.w + 1u);
    return marked;
}

void main()
{
    uint i = itemOf() / lanes, lane = gl_LocalInvocationID.x % lanes, place = gl_LocalInvocationID.x / lanes;
    if (itemOf() == 0u)
        results[runCounter] = runNumber;
    bool isTested = i < partCount && (parts[min(i, partCount - 1u)].y & usesTest) != 0u;
    uint step = isTested ? parts[i].y >> 2 : 0u;
    Triangle t;
    if (isTested)
        t = triangles[i];
    if (lane == 0u)
        found[place] = 0u;
    barrier();
    if (isTested && isHidden(t, step, lane))
        atomicOr(found[place], isHiddenPart);
    barrier();
    bool isOpen = isTested && found[place] == 0u && hasSample(t.box);
    barrier();
    if (isOpen && markHiders(t, step, lane))
        atomicOr(found[place], usesTest);
    barrier();
    if (isTested && lane == 0u && found[place] != 0u)
        atomicOr(results[firstResult + i], found[place]);
}
