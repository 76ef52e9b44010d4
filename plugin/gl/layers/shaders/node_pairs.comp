// Pairs of active nodes whose boxes overlap and whose bodies collide; pairs within one body, and of a node with itself, only
// if the body self-collides. A workgroup compares a tile of 64 nodes with some tiles, itself or later ones.
layout(std430, binding = 2) readonly buffer Boxes { uvec4 inBoxes[]; };
// Node, node not below it, their pair masks or none.
layout(std430, binding = 5) writeonly buffer NodePairs { uvec4 outNodePairs[]; };

// Four invocations for each node of the tile.
const uint nodesOfInvocation = 64u * 64u / LOCAL_SIZE, nodesOfRound = nodesOfInvocation / 2u;

shared uint tileCount, tiles[64]; // whose boxes overlap that of the workgroup's tile
shared uint nodesOfB[64], bodiesOfB[64];
shared uvec4 boxesOfB[64];
shared uint foundCount, firstFound;
shared uvec2 found[LOCAL_SIZE * nodesOfRound];

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

// The box of an active node; past the last one an empty box.
uvec4 boxOf(uint i)
{
    return i < activeNodes ? inBoxes[nodeBoxesAt + i] : packBox(uvec4(highestLevel), uvec4(0u));
}

uint bodyOf(uint node)
{
    return texelFetch(nodes, int(node)).x;
}

// The pair masks of adjacent nodes; none: these are not adjacent. Links lead from lower to higher nodes.
uint tableOf(uvec2 pair)
{
    uvec2 range = texelFetch(nodes, int(pair.x)).yz; // first, end
    uint link = testNeighbours != 0u ? range.y : range.x, table = none;
    for (; link < range.y && table == none; link++)
    {
        uvec2 adjacent = texelFetch(links, int(link)).xy;
        table = adjacent.x == pair.y ? adjacent.y : none;
    }
    // Some implementations stop the loops of an invocation after 65 535 iterations in all.
    if (link < range.y && table == none)
        counters[stoppedCounter] = 1u;
    return table;
}

// One append for all that was found.
void writeFound(uint k)
{
    barrier();
    uint count = foundCount;
    if (k == 0u && count != 0u)
        firstFound = append(nodePairCounter, count);
    barrier();
    for (uint i = k; i < count; i += LOCAL_SIZE)
        outNodePairs[min(firstFound + i, nodePairCapacity)] = uvec4(found[i], tableOf(found[i]), 0u);
    if (k == 0u)
        foundCount = 0u;
    barrier();
}

// Compares a node of A with some of the nodes of tile B. `first`: of these, the first to compare with.
void compareWith(uint b, uint first, uvec4 box, uint node, uint body, uint k)
{
    barrier();
    if (k < 64u)
    {
        uint j = b * 64u + k;
        nodesOfB[k] = j < activeNodes ? activeNode(j) : 0u;
        bodiesOfB[k] = bodyOf(nodesOfB[k]);
        boxesOfB[k] = boxOf(j);
    }
    barrier();
    bool selfCollides = bodySelfCollides(body);
    uint begin = (k >> 6) * nodesOfInvocation;
    for (uint base = begin; base < begin + nodesOfInvocation; base += nodesOfRound)
    {
        for (uint m = base; m < base + nodesOfRound; m++)
        {
            uvec4 other = boxesOfB[m];
            if (m >= first && OVERLAP(box, other) &&
                (bodiesOfB[m] == body ? selfCollides : mayCollide(body, bodiesOfB[m])))
                found[atomicAdd(foundCount, 1u)] = uvec2(min(node, nodesOfB[m]), max(node, nodesOfB[m]));
        }
        writeFound(k);
    }
}

void main()
{
    uint tilesInAll = (activeNodes + 63u) / 64u, k = gl_LocalInvocationID.x;
    uint part = GROUP / max(tilesInAll, 1u), a = GROUP - part * tilesInAll, first = a + part * tilesOfGroup, b = first + k;
    if (first >= tilesInAll)
        return;

    if (k == 0u)
        tileCount = foundCount = 0u;
    barrier();
    if (k < tilesOfGroup && b < tilesInAll && tilesOverlap(a, b))
        tiles[atomicAdd(tileCount, 1u)] = b;
    barrier();
    uint i = a * 64u + (k & 63u), node = i < activeNodes ? activeNode(i) : 0u, count = tileCount;
    uvec4 box = boxOf(i);
    uint body = bodyOf(node);
    for (uint t = 0u; t < count; t++)
        compareWith(tiles[t], tiles[t] == a ? k & 63u : 0u, box, node, body, k);
}
