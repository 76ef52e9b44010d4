// Pairs of active nodes whose boxes overlap and whose bodies collide; pairs within one body, and of a node with itself, only
// if the body self-collides. A workgroup compares a tile with some tiles, itself or later ones.
layout(std430, binding = 2) readonly buffer Boxes { uvec4 inBoxes[]; };
// Node, node not below it, their pair masks or none.
layout(std430, binding = 5) writeonly buffer NodePairs { uvec4 outNodePairs[]; };

const uint comparisons = TILE_NODES * TILE_NODES; // of two tiles, one each invocation

shared uint tileCount, tiles[LOCAL_SIZE];
shared uint foundCount, firstFound;
shared uvec2 found[2u * comparisons];
shared uint tableOf[2u * comparisons]; // pair masks of adjacent nodes; none: these are not adjacent

bool mayCollide(uint a, uint b)
{
    uint groupA = bodyWord(a, 0u), groupB = bodyWord(b, 0u), ownerA = bodyWord(a, 3u);
    return ((bodyWord(a, 2u) | bodyWord(b, 2u)) & isMoving) != 0u && (groupA & bodyWord(b, 1u)) != 0u &&
           (groupB & bodyWord(a, 1u)) != 0u && (ownerA == 0u || ownerA != bodyWord(b, 3u));
}

// An end of a tile's box: the lower ones, then highest level - upper ones.
uint tileEnd(uint tile, uint end)
{
    return counters[COUNTER_WORDS + tile * tileWords + end];
}

// Lower ends are not above the other's upper ends.
bool tilesOverlap(uint a, uint b)
{
    bool overlap = true;
    for (uint axis = 0u; axis < 4u; axis++)
        overlap = overlap && tileEnd(a, axis) + tileEnd(b, 4u + axis) <= highestLevel &&
                  tileEnd(b, axis) + tileEnd(a, 4u + axis) <= highestLevel;
    return overlap;
}

// A comparison each invocation: a node of tile `a` and one of tile `b`, not before it.
void compareTiles(uint a, uint b, uint k)
{
    uint i = a * TILE_NODES + k % TILE_NODES, j = b * TILE_NODES + k / TILE_NODES;
    if (j < i || j >= activeNodes)
        return;
    uvec4 p = inBoxes[nodeBoxesAt + i], q = inBoxes[nodeBoxesAt + j];
    if (!OVERLAP(p, q))
        return;
    uint m = activeNode(i), n = activeNode(j), bodyM = texelFetch(nodes, int(m)).x, bodyN = texelFetch(nodes, int(n)).x;
    if (bodyM == bodyN ? bodySelfCollides(bodyM) : mayCollide(bodyM, bodyN))
        found[atomicAdd(foundCount, 1u)] = uvec2(min(m, n), max(m, n));
}

// Some implementations stop the loops of an invocation after 65 535 iterations in all.
void checkDone(bool isDone)
{
    if (!isDone)
        counters[stoppedCounter] = 1u;
}

// The pair masks of adjacent nodes: 8 invocations look through a node's links. Links lead from lower to higher nodes.
void findTables(uint count, uint k)
{
    for (uint i = k; i < count; i += LOCAL_SIZE)
        tableOf[i] = none;
    barrier();
    uint i = testNeighbours != 0u ? count : k >> 3;
    for (; i < count; i += LOCAL_SIZE / 8u)
    {
        uvec2 range = texelFetch(nodes, int(found[i].x)).yz; // first, end
        uint link = range.x + (k & 7u);
        for (; link < range.y; link += 8u)
        {
            uvec2 adjacent = texelFetch(links, int(link)).xy;
            if (adjacent.x == found[i].y)
                tableOf[i] = adjacent.y;
        }
        checkDone(link >= range.y);
    }
    checkDone(i >= count);
    barrier();
}

// One append for all that was found.
void writeFound(uint k)
{
    uint count = foundCount;
    findTables(count, k);
    if (k == 0u && count != 0u)
        firstFound = append(nodePairCounter, count);
    barrier();
    for (uint i = k; i < count; i += LOCAL_SIZE)
        outNodePairs[min(firstFound + i, nodePairCapacity)] = uvec4(found[i], tableOf[i], 0u);
    if (k == 0u)
        foundCount = 0u;
    barrier();
}

void main()
{
    countKernel(nodePairsRan);
    uint tilesInAll = (activeNodes + TILE_NODES - 1u) / TILE_NODES, k = gl_LocalInvocationID.x;
    uint part = GROUP / max(tilesInAll, 1u), a = GROUP - part * tilesInAll, b = a + part + k * partsOfTile, t = 0u;
    if (part >= partsOfTile)
        return;

    if (k == 0u)
        tileCount = foundCount = 0u;
    barrier();
    if (b < tilesInAll && tilesOverlap(a, b))
        tiles[atomicAdd(tileCount, 1u)] = b;
    barrier();
    for (; t < tileCount; t++)
    {
        compareTiles(a, tiles[t], k);
        barrier();
        if (foundCount > comparisons)
            writeFound(k);
        barrier();
    }
    checkDone(t >= tileCount);
    if (foundCount != 0u)
        writeFound(k);
}
