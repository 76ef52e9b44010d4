// The clusters of two nodes against each other.
layout(std430, binding = 1) buffer ClusterPairs { uint outClusterPairs[]; }; // node pair << 6 | cluster + 8 * cluster
uniform uint nodePairCapacity, clusterPairCapacity;

void main()
{
    uint i = ITEM;
    if (i >= countOf(nodePairCounter, nodePairCapacity))
        return;

    uvec2 pair = texelFetch(nodePairs, int(i)).xy;
    // Within one node: each two clusters once, and each with itself.
    uvec2 mask = pair.x == pair.y ? uvec2(0x0f070301u, 0xff7f3f1fu) : uvec2(none);
    EIGHT_AGAINST_EIGHT(clusterBoxes, int(pair.x * 8u), int(pair.y * 8u), mask)
    WRITE_BITS(outClusterPairs, clusterPairCapacity, clusterPairCounter, i, mask)
}
