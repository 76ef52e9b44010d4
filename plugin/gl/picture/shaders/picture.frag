// Shades a mesh or the ground. Follows normal.glsl.
uniform sampler2D lights; // ambient light, key light, depth; coarser than the picture
uniform vec4 place;       // x, y: of the tile in the picture; z, w: 1 / size of the picture
uniform vec3 up;
uniform vec3 light;
uniform vec3 front;
uniform vec3 back;
uniform float glow;       // 0: shaded; 1: the plain colour
uniform bool isGround;
uniform vec3 middle;      // of the ground
uniform float extent;
uniform vec4 tiles;       // xyz: a corner of a tile; w: width, or 0
uniform vec3 background;
out vec4 color;

/// Of the four nearest pixels of the light, those at the depth of this one.
vec2 receivedLight()
{
    ivec2 last = textureSize(lights, 0) - 1;
    vec2 at = (gl_FragCoord.xy + place.xy) * place.zw * vec2(last + 1) - 1.0;
    ivec2 first = ivec2(floor(at));
    vec2 part = at - vec2(first);
    float depth = 1.0 / gl_FragCoord.w;
    vec2 sum = vec2(0.0);
    float weights = 0.0;
    for (int i = 0; i < 4; ++i)
    {
        ivec2 step = ivec2(i & 1, i >> 1);
        vec3 found = texelFetch(lights, clamp(first + step, ivec2(0), last), 0).xyz;
        vec2 share = mix(1.0 - part, part, vec2(step));
        float weight = (share.x * share.y + 0.01) / (0.003 + abs(found.z / depth - 1.0));
        sum += weight * found.xy;
        weights += weight;
    }
    return sum / weights;
}

vec3 groundColor()
{
    vec3 p = fromEye - tiles.xyz;
    vec3 side = abs(up.x) < 0.9 ? vec3(1.0, 0.0, 0.0) : vec3(0.0, 0.0, 1.0);
    side = normalize(side - dot(side, up) * up);
    vec2 q = vec2(dot(p, side), dot(p, cross(side, up))) / max(tiles.w, 1e-6);
    // A chequerboard, averaged over the pixel.
    vec2 width = fwidth(q) + 1e-4;
    vec2 i = 2.0 * (abs(fract(0.5 * q - 0.25 * width) - 0.5) - abs(fract(0.5 * q + 0.25 * width) - 0.5)) / width;
    float odd = 0.5 - 0.5 * i.x * i.y;
    return tiles.w > 0.0 ? mix(0.86, 1.0, odd) * front : front;
}

void main()
{
    vec3 base = isGround ? groundColor() : gl_FrontFacing ? front : back;
    vec3 toEye = -normalize(fromEye);
    vec3 n = isGround ? up : findNormal();
    vec2 received = receivedLight();
    float sky = 0.5 + 0.5 * dot(n, up);
    vec3 ambient = mix(vec3(0.17, 0.16, 0.15), vec3(0.34, 0.36, 0.39), sky) * received.x;
    float key = max(dot(n, light), 0.0) * received.y;
    // From the other side, without shadows: keeps what is in shadow from looking flat.
    float fill = max(dot(n, normalize(toEye + 0.6 * cross(up, toEye))), 0.0) * received.x;
    float shine = pow(max(dot(n, normalize(light + toEye)), 0.0), 40.0) * received.y;
    vec3 shaded = (ambient + 0.84 * vec3(1.0, 0.98, 0.95) * key + 0.10 * fill) * base;
    if (!isGround)
        shaded += 0.04 * shine;
    color = vec4((edges ? 0.3 : 1.0) * mix(shaded, base, glow), 1.0);
    if (isGround)
        color.rgb = mix(color.rgb, background, smoothstep(0.3 * extent, extent, length(fromEye - middle)));
}
