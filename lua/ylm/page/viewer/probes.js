// Reads '.ylmp', probes of ylm: docs/engines.md has the format. Nothing of three.js is used.

const MAGIC = [ 0x89, 89, 76, 77, 80, 13, 10, 26 ], SPLIT = 255, DEPTH = 19, HEADER = 116, WIDTH = 1024, FRONT = 3 / 16, TOP = 1 << 18, MOST = 1 << 23;

const single = new Float32Array( 1 ), word = new Uint32Array( single.buffer );

function half( x ) {
	single[ 0 ] = x;
	const sign = word[ 0 ] >>> 16 & 0x8000, exponent = ( word[ 0 ] >>> 23 & 255 ) - 112, mantissa = word[ 0 ] & 0x7fffff;
	if ( exponent >= 31 ) return sign | 0x7bff;
	if ( exponent > 0 ) return Math.min( ( exponent << 10 ) + ( mantissa + 0x1000 >> 13 ), 0x7bff ) | sign;
	return exponent < - 10 ? sign : sign | ( mantissa | 0x800000 ) + ( 1 << 13 - exponent ) >> 14 - exponent;
}

// Number of `bits` bits, the lowest first, from bit `at` of the bytes.
function unpack( bytes, at, bits ) {
	const k = at >> 3;
	return ( bytes[ k ] | bytes[ k + 1 ] << 8 | bytes[ k + 2 ] << 16 ) >>> ( at & 7 ) & ( 1 << bits ) - 1;
}

function demand( truth, what ) { if ( ! truth ) throw new Error( 'probes of ylm: ' + what ); }

function header( view ) {
	demand( view.byteLength >= HEADER && MAGIC.every( ( x, i ) => view.getUint8( i ) === x ), 'another file' );
	demand( view.getUint32( 8, true ) === 2, 'another version' );
	demand( view.getUint32( 24, true ) === view.byteLength, 'the file is cut off' );
	const [ rx, ry, rz, cells, several, bricks, points ] = [ 0, 1, 2, 3, 4, 5, 6 ].map( i => view.getUint32( 80 + 4 * i, true ) );
	const bounds = [ 0, 1, 2, 3, 4, 5 ].map( i => view.getFloat64( 32 + 8 * i, true ) );
	const [ lmax, bits, name ] = [ 108, 109, 110 ].map( i => view.getUint8( i ) ), names = view.getUint32( 112, true );
	demand( ( lmax === 1 || lmax === 2 ) && bits >= 6 && bits <= 16 && name >= 1 && name <= 32, 'other numbers' );
	demand( rx * ry * rz <= cells && cells + bricks + names * name / 8 < view.byteLength && bricks < MOST, 'its counts cannot be' );
	return { roots: [ rx, ry, rz ], cells, several, bricks, points, bounds, lmax, bits, name, names };
}

// Cells in the order of the file: level, first child or brick, bricks (SPLIT: children).
function tree( bytes, h ) {
	const level = new Uint8Array( h.cells ), first = new Uint32Array( h.cells );
	let next = h.roots[ 0 ] * h.roots[ 1 ] * h.roots[ 2 ], bricks = 0;
	for ( let i = 0; i < h.cells; i ++ ) {
		const parts = bytes[ HEADER + i ];
		first[ i ] = parts === SPLIT ? next : bricks;
		if ( parts === SPLIT ) {
			demand( next + 8 <= h.cells && level[ i ] < DEPTH, 'its tree cannot be' );
			level.fill( level[ i ] + 1, next, next + 8 );
			next += 8;
		} else bricks += parts;
	}
	demand( next === h.cells && bricks === h.bricks, 'its tree cannot be' );
	return { level, first, parts: bytes.subarray( HEADER, HEADER + h.cells ) };
}

// Words of leaves' planes, two a texel: the planes, the last one first, then the brick of each side, counted from the leaf's first;
// `at` [cells] the texel of the sides and the planes' number. Returns the bytes' end.
function planes( view, h, t, words, at ) {
	let k = HEADER + ( h.cells + 3 & ~ 3 );
	for ( let i = 0; i < h.cells; i ++ ) {
		if ( t.parts[ i ] < 2 || t.parts[ i ] === SPLIT ) continue;
		const n = view.getUint8( k ++ ), snorm = x => Math.round( 32767 / 4 * x ) & 0xffff;
		demand( n > 0 && n < 5, 'its planes cannot be' );
		for ( let j = n - 1; j >= 0; j -- ) {
			const of = [ 0, 1, 2 ].map( a => snorm( view.getInt8( k + 5 * j + a ) / 127 ) );
			words.push( ( of[ 0 ] | of[ 1 ] << 16 ) >>> 0, ( of[ 2 ] | snorm( view.getInt16( k + 5 * j + 3, true ) / 8192 ) << 16 ) >>> 0 );
		}
		k += 5 * n;
		at[ i ] = words.length / 2 * 8 + n;
		for ( let j = 0; j < 1 << n; j ++ ) {
			const part = view.getUint8( k + ( j >> 1 ) ) >> 4 * ( j & 1 ) & 15;
			demand( part < t.parts[ i ], 'its planes cannot be' );
			words.push( t.first[ i ] + part, 0 );
		}
		k += ( 1 << n ) / 2;
	}
	return k + 3 & ~ 3;
}

// The texture of the tree: a table of equal cells, below it eight children each, then planes. Two words a texel. A dark leaf has the
// brick after the last.
function texels( view, h, t ) {
	let top = 0, deepest = 0, groups = 0;
	const [ rx, ry, rz ] = h.roots, base = new Uint32Array( h.cells ), at = new Uint32Array( h.cells );
	for ( const l of t.level ) deepest = Math.max( deepest, l );
	while ( top < deepest && rx * ry * rz * 8 ** ( top + 1 ) <= TOP ) top ++;
	const table = rx * ry * rz * 8 ** top;
	for ( let i = 0; i < h.cells; i ++ ) if ( t.parts[ i ] === SPLIT && t.level[ i ] >= top ) base[ i ] = table + 8 * groups ++;
	const words = new Array( 2 * ( table + 8 * groups ) ).fill( 0 ), end = planes( view, h, t, words, at );
	function put( texel, i ) {
		const split = t.parts[ i ] === SPLIT;
		words[ 2 * texel ] = split ? ( 0x80000000 | base[ i ] ) >>> 0 : 127 + t.level[ i ] << 23 | ( t.parts[ i ] ? t.first[ i ] : h.bricks );
		words[ 2 * texel + 1 ] = at[ i ];
	}
	function fill( i, x, y, z ) {
		const n = 1 << top - t.level[ i ];
		if ( t.parts[ i ] === SPLIT && t.level[ i ] < top ) {
			for ( let k = 0; k < 8; k ++ ) fill( t.first[ i ] + k, 2 * x + ( k & 1 ), 2 * y + ( k >> 1 & 1 ), 2 * z + ( k >> 2 ) );
			return;
		}
		for ( let c = 0; c < n; c ++ ) for ( let b = 0; b < n; b ++ ) for ( let a = 0; a < n; a ++ )
			put( x * n + a + ( rx << top ) * ( y * n + b + ( ry << top ) * ( z * n + c ) ), i );
	}
	for ( let z = 0, i = 0; z < rz; z ++ ) for ( let y = 0; y < ry; y ++ ) for ( let x = 0; x < rx; x ++ ) fill( i ++, x, y, z );
	for ( let i = 0; i < h.cells; i ++ ) if ( base[ i ] ) for ( let k = 0; k < 8; k ++ ) put( base[ i ] + k, t.first[ i ] + k );
	const height = Math.ceil( words.length / 2 / WIDTH ), data = new Int32Array( 2 * WIDTH * height );
	data.set( words );
	return { top, end, height, data };
}

// Numbers of a point, channels beside each other, as its texels have them: 1, y, z, x of each channel, xy, yz, xz, z z of each, then
// x x - y y of all three.
function arranged( v, to ) {
	for ( let c = 0; c < 3; c ++ ) {
		for ( let k = 0; k < 4; k ++ ) to[ 4 * c + k ] = v[ 3 * k + c ];
		if ( v.length === 12 ) continue;
		[ 4, 5, 7 ].forEach( ( k, i ) => to[ 12 + 4 * c + i ] = v[ 3 * k + c ] );
		to[ 4 * c ] -= v[ 18 + c ]; // of 3 z z - 1
		to[ 15 + 4 * c ] = 3 * v[ 18 + c ];
		to[ 24 + c ] = v[ 24 + c ];
	}
}

// Lower corners of cells, and their edges, in edges of the smallest: [ x, y, z, edge ].
function lattice( h, t ) {
	const deepest = t.level.reduce( ( a, b ) => Math.max( a, b ), 0 ), at = new Array( h.cells ), [ rx, ry, rz ] = h.roots, e = 2 ** deepest;
	for ( let z = 0, i = 0; z < rz; z ++ ) for ( let y = 0; y < ry; y ++ ) for ( let x = 0; x < rx; x ++ ) at[ i ++ ] = [ x * e, y * e, z * e, e ];
	for ( let i = 0; i < h.cells; i ++ ) {
		const [ x, y, z, edge ] = at[ i ], d = edge / 2;
		for ( let k = 0; t.parts[ i ] === SPLIT && k < 8; k ++ )
			at[ t.first[ i ] + k ] = [ x + ( k & 1 ) * d, y + ( k >> 1 & 1 ) * d, z + ( k >> 2 ) * d, d ];
	}
	return at;
}

// Points of bricks' corners, those behind the file's points are means of others: { corner [ bricks ][ 8 ], means, end }.
function corners( bytes, h, t, from ) {
	const at = lattice( h, t ), last = new Map(), corner = new Uint32Array( 8 * h.bricks ), means = [];
	const begin = from + ( h.bricks + 3 & ~ 3 );
	let read = 0;
	function name() {
		const bit = 8 * begin + h.name * read ++;
		demand( read <= h.names, 'a corner has no point' );
		return unpack( bytes, bit, Math.min( 16, h.name ) ) + ( h.name > 16 ? 65536 * unpack( bytes, bit + 16, h.name - 16 ) : 0 );
	}
	function point( n ) {
		demand( n < h.points || n >= h.points + 2 && n < h.points + 2 + means.length, 'a brick has no such point' );
		return n < h.points ? n : n - 2;
	}
	function named() {
		const n = name();
		if ( n !== h.points && n !== h.points + 1 ) return point( n );
		means.push( Array.from( { length: n === h.points ? 2 : 4 }, () => point( name() ) ) );
		return h.points + means.length - 1;
	}
	for ( let i = 0; i < h.cells; i ++ ) for ( let b = 0; t.parts[ i ] !== SPLIT && b < t.parts[ i ]; b ++ ) {
		const brick = t.first[ i ] + b, [ x, y, z, e ] = at[ i ], beside = [];
		for ( let k = 0; k < 8; k ++ ) {
			const place = `${ x + ( k & 1 ) * e } ${ y + ( k >> 1 & 1 ) * e } ${ z + ( k >> 2 ) * e }`, own = `${ place } ${ b }`;
			const p = bytes[ from + brick ] >> k & 1 ? named() : last.get( own ) ?? last.get( place ) ?? beside[ k & k - 1 ];
			demand( p !== undefined, 'a corner has no point' );
			last.set( place, p ).set( own, p );
			corner[ 8 * brick + k ] = beside[ k ] = p;
		}
	}
	return { corner, means, end: begin + ( Math.ceil( h.names * h.name / 8 ) + 3 & ~ 3 ) };
}

// Numbers of the file's points and of means.
function numbers( view, bytes, h, means, begin ) {
	const n = 3 * ( h.lmax + 1 ) ** 2, size = Math.ceil( ( 16 + n * h.bits ) / 8 ), v = new Float64Array( n * ( h.points + means.length ) );
	demand( begin + ( size * h.points + 3 & ~ 3 ) === bytes.length, 'its length is another' );
	for ( let i = 0; i < h.points; i ++ ) {
		const k = begin + i * size, step = 2 ** ( ( view.getUint16( k, true ) - 32768 ) / 512 );
		for ( let j = 0; j < n; j ++ ) {
			const q = unpack( bytes, 8 * k + 16 + j * h.bits, h.bits );
			v[ n * i + j ] = step * ( q >> h.bits - 1 ? q - ( 1 << h.bits ) : q );
		}
	}
	means.forEach( ( ends, i ) => {
		for ( let j = 0; j < n; j ++ ) for ( const p of ends ) v[ n * ( h.points + i ) + j ] += v[ n * p + j ] / ends.length;
	} );
	return v;
}

// The texture of bricks: 2 x 2 x 2 texels each, volumes of four numbers above each other; behind them a dark one.
function atlas( view, bytes, h, c ) {
	const n = 3 * ( h.lmax + 1 ) ** 2, volumes = h.lmax > 1 ? 7 : 3, all = h.points + c.means.length;
	const v = numbers( view, bytes, h, c.means, c.end ), to = new Float64Array( 4 * volumes ), points = new Uint16Array( 4 * volumes * all );
	for ( let i = 0; i < all; i ++ ) {
		arranged( v.subarray( n * i, n * i + n ), to );
		for ( let j = 0; j < 4 * volumes; j ++ ) points[ 4 * volumes * i + j ] = half( to[ j ] );
	}
	const bx = Math.min( 128, h.bricks + 1 ), by = Math.min( 128, Math.ceil( ( h.bricks + 1 ) / bx ) );
	const bz = Math.ceil( ( h.bricks + 1 ) / ( bx * by ) ), data = new Uint16Array( 32 * bx * by * bz * volumes );
	for ( let i = 0; i < 8 * h.bricks; i ++ ) {
		const b = i >> 3, k = i & 7, p = c.corner[ i ];
		const x = 2 * ( b % bx ) + ( k & 1 ), y = 2 * ( Math.floor( b / bx ) % by ) + ( k >> 1 & 1 );
		for ( let v = 0; v < volumes; v ++ ) {
			const z = 2 * ( v * bz + Math.floor( b / ( bx * by ) ) ) + ( k >> 2 );
			data.set( points.subarray( 4 * ( volumes * p + v ), 4 * ( volumes * p + v ) + 4 ), 4 * ( x + 2 * bx * ( y + 2 * by * z ) ) );
		}
	}
	return { data, size: [ 2 * bx, 2 * by, 2 * bz * volumes ] };
}

// The largest float below a whole number.
function below( n ) {
	single[ 0 ] = n;
	word[ 0 ] --;
	return single[ 0 ];
}

// Textures and numbers of a file for the shader: { tree: { data, width, height } of two whole numbers of 32 bits a texel, atlas: { data, size } of
// four halves a texel, bounds, uniforms: numbers and lists of three by the shader's names }.
function readProbes( buffer ) {
	const view = new DataView( buffer ), bytes = new Uint8Array( buffer ), h = header( view );
	const cells = tree( bytes, h ), t = texels( view, h, cells ), a = atlas( view, bytes, h, corners( bytes, h, cells, t.end ) );
	const top = 2 ** t.top, [ rx, ry ] = h.roots;
	const scale = h.roots.map( ( n, i ) => n / ( h.bounds[ i + 3 ] - h.bounds[ i ] ) );
	return { bounds: h.bounds, tree: { data: t.data, width: WIDTH, height: t.height }, atlas: a,
		uniforms: { ylm_low: h.bounds.slice( 0, 3 ), ylm_scale: scale, ylm_end: h.roots.map( below ), ylm_ahead: scale.map( s => FRONT / s ),
			ylm_table: [ 1, rx * top, rx * ry * top * top ], ylm_texel: a.size.map( n => 2 / n ), ylm_top: top, ylm_lmax: h.lmax,
			ylm_volume: [ 0, 0, h.lmax > 1 ? 1 / 7 : 1 / 3 ] } };
}
